// SPDX-License-Identifier: MIT
#include "io/recording/events.hpp"

#include <cmath>
#include <limits>

#include "common/error.hpp"

namespace sixdeg {

RecordedEvents::RecordedEvents(const std::string &path, const Guess &guess, const std::vector<SensorSource> &sensors)
    : reader_(std::filesystem::path(path)), is_edge_times_(guess.is_edge_times), has_cam_(guess.cam.has_value()),
      cam_rising_(guess.cam && guess.cam->edge == Edge::rising), crank_rising_(guess.edge == Edge::rising),
      crank_column_(std::size_t(guess.column)), cam_column_(guess.cam ? std::size_t(guess.cam->column) : 0), unit_s_(guess.unit_s),
      crank_(guess.slicing), cam_(guess.cam ? guess.cam->slicing : Slicing{}), added_(guess) {
    std::vector<int> used;
    if (!is_edge_times_) used.push_back(guess.column);
    if (guess.cam) used.push_back(guess.cam->column);
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
        crank_.finish(), cam_.finish();
        take_edges();
        return false;
    }
    const double time = reader_.time();
    const std::vector<double> &values = reader_.values();
    if (is_edge_times_) crank_.falling.push_back(time);
    else crank_.row(time, values[crank_column_]);
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
    if (waiting_.empty()) return false;
    event = waiting_.top();
    waiting_.pop();
    return true;
}

} // namespace sixdeg
