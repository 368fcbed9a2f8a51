// SPDX-License-Identifier: MIT
#include "io/recording/events.hpp"

#include <cmath>
#include <limits>

#include "common/error.hpp"

namespace sixdeg {

RecordedEvents::RecordedEvents(const std::string &path, const Guess &guess, const std::vector<SensorSource> &sensors)
    : reader_(std::filesystem::path(path)), is_edge_times_(guess.is_edge_times), has_cam_(guess.cam && guess.cam->file.empty()),
      has_home_(guess.home.has_value()), cam_rising_(guess.cam && guess.cam->edge == Edge::rising),
      home_rising_(guess.home && guess.home->edge == Edge::rising), crank_rising_(guess.edge == Edge::rising),
      crank_column_(std::size_t(guess.column)), cam_column_(guess.cam ? std::size_t(guess.cam->column) : 0),
      home_column_(guess.home ? std::size_t(guess.home->column) : 0), unit_s_(guess.unit_s), crank_(guess.slicing),
      cam_(guess.cam ? guess.cam->slicing : Slicing{}), home_(guess.home ? guess.home->slicing : Slicing{}), added_(guess) {
    std::vector<int> used;
    if (!is_edge_times_) used.push_back(guess.column);
    if (has_cam_) used.push_back(guess.cam->column);
    if (has_home_) used.push_back(guess.home->column);
    for (const SensorSource &sensor : sensors) {
        if (sensor.constant) {
            waiting_.push({RecordedEvent::reading, 0, sensor.input, *sensor.constant});
        } else if (sensor.file.empty()) {
            columns_.push_back(sensor);
            used.push_back(sensor.column);
        }
    }
    last_reading_.assign(columns_.size(), std::numeric_limits<double>::quiet_NaN());
    reader_.read_only(used);
    read_row(); // tells the origin, which other files are shifted by
    origin_s_ = reader_.time_origin().value() * unit_s_;
    for (const SensorSource &sensor : sensors)
        if (!sensor.constant && !sensor.file.empty()) open(sensor);
    if (guess.cam && !has_cam_) open_cam(*guess.cam);
}

void RecordedEvents::open_cam(const CamGuess &cam) {
    RowReader reader{std::filesystem::path(cam.file)};
    cam_file_ = std::make_unique<CamFile>(CamFile{cam, std::move(reader), EdgeFinder(cam.slicing), {}});
    cam_file_->reader.read_only({cam.column});
    find_cam_edge();
}

/// Reads the cam's file up to its next edge.
void RecordedEvents::find_cam_edge() {
    CamFile &file = *cam_file_;
    std::vector<double> &found = file.cam.edge == Edge::rising ? file.finder.rising : file.finder.falling;
    while (file.edge_s.empty() && !file.ended) {
        file.ended = !file.reader.next();
        if (file.ended) file.finder.finish();
        else if (file.cam.is_edge_times) found.push_back(file.reader.time());
        else file.finder.row(file.reader.time(), file.reader.values()[std::size_t(file.cam.column)]);
        for (double time : found) file.edge_s.push_back((file.reader.time_origin().value() + time) * file.cam.unit_s - origin_s_);
        file.finder.rising.clear(), file.finder.falling.clear();
    }
}

void RecordedEvents::open(const SensorSource &sensor) {
    RowReader reader{std::filesystem::path(sensor.file)};
    const double stated = reader.layout().time_unit_s;
    auto file = std::make_unique<OtherFile>(OtherFile{sensor, std::move(reader), stated > 0 ? stated : 1, 0});
    file->reader.read_only({sensor.column});
    step(*file);
    files_.push_back(std::move(file));
}

/// The next reading of another file; its times are those of the recording.
void RecordedEvents::step(OtherFile &file) {
    file.ended = !file.reader.next();
    if (file.ended) return;
    file.t_s = (file.reader.time_origin().value() + file.reader.time()) * file.unit_s - origin_s_;
    file.value = file.reader.values()[std::size_t(file.source.column)] * file.source.scale;
}

void RecordedEvents::take_edges() {
    for (double time : home_rising_ ? home_.rising : home_.falling) added_.reference(time);
    home_.rising.clear(), home_.falling.clear();
    std::vector<double> &found = crank_rising_ ? crank_.rising : crank_.falling;
    for (double time : found) added_.edge(time, edges_);
    if (ended_) added_.finish(edges_);
    for (double time : edges_) {
        push(RecordedEvent::crank_edge, time, 0, 0);
        newest_edge_s_ = time * unit_s_;
    }
    edges_.clear();
    crank_.rising.clear(), crank_.falling.clear();
    for (double time : cam_rising_ ? cam_.rising : cam_.falling) push(RecordedEvent::cam_edge, time, 0, 0);
    cam_.rising.clear(), cam_.falling.clear();
}

bool RecordedEvents::read_row() {
    if (ended_) return false;
    ended_ = !reader_.next();
    if (ended_) {
        crank_.finish(), cam_.finish(), home_.finish();
        take_edges();
        return false;
    }
    const double time = reader_.time();
    const std::vector<double> &values = reader_.values();
    if (is_edge_times_) crank_.falling.push_back(time);
    else crank_.row(time, values[crank_column_]);
    if (has_home_) home_.row(time, values[home_column_]);
    if (has_cam_) cam_.row(time, values[cam_column_]);
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        const double value = values[std::size_t(columns_[i].column)] * columns_[i].scale;
        if (std::isnan(value) || value == last_reading_[i]) continue;
        last_reading_[i] = value;
        push(RecordedEvent::reading, time, columns_[i].input, value);
    }
    take_edges();
    return true;
}

bool RecordedEvents::next(RecordedEvent &event) {
    // A cam edge may be found after the crank edge behind it, so the newest crank edge waits for the next one.
    while (!ended_ && (waiting_.empty() || waiting_.top().t_s >= newest_edge_s_)) read_row();
    for (const auto &file : files_) {
        if (file->ended || (!waiting_.empty() && file->t_s > waiting_.top().t_s)) continue;
        event = {RecordedEvent::reading, file->t_s, file->source.input, file->value};
        step(*file);
        if (!std::isnan(event.value)) return true;
        return next(event);
    }
    if (cam_file_ && !cam_file_->edge_s.empty() && (waiting_.empty() || cam_file_->edge_s.front() <= waiting_.top().t_s)) {
        event = {RecordedEvent::cam_edge, cam_file_->edge_s.front(), 0, 0};
        cam_file_->edge_s.pop_front();
        find_cam_edge();
        return true;
    }
    if (waiting_.empty()) return false;
    event = waiting_.top();
    waiting_.pop();
    return true;
}

} // namespace sixdeg
