// SPDX-License-Identifier: MIT
// A recording as a stream of crank edges, cam edges and readings in order of time. Memory does not grow with the file.
#pragma once
#include <deque>
#include <memory>
#include <optional>
#include <queue>
#include <string>
#include <vector>

#include "io/recording/guess.hpp"

namespace sixdeg {

/// Where the readings of one sensor come from: a constant, a column of the recording, or another file of times and values.
struct SensorSource {
    int input = 0;                 ///< The caller's number for the sensor.
    std::optional<double> constant;
    int column = -1;               ///< Of the recording, or of `file`.
    std::string file;              ///< Empty: the recording itself.
    double scale = 1;              ///< From the file's unit to the sensor's.
};

struct RecordedEvent {
    enum Kind { cam_edge, reading, crank_edge } kind;
    double t_s;
    int input;    ///< Of a reading.
    double value;
};

class RecordedEvents {
  public:
    /// `guess` was made from the same file. Throws InputError for a file that cannot be read.
    RecordedEvents(const std::string &path, const Guess &guess, const std::vector<SensorSource> &sensors);
    /// The next event; false at the end. Throws InputError where a row cannot be read.
    bool next(RecordedEvent &event);
    /// Times are counted from here, in s of the file; 0 unless its times are negative or too large.
    double origin_s() const { return origin_s_; }

  private:
    struct Later {
        bool operator()(const RecordedEvent &a, const RecordedEvent &b) const { return a.t_s != b.t_s ? a.t_s > b.t_s : a.kind > b.kind; }
    };
    struct OtherFile {
        SensorSource source;
        RowReader reader;
        double unit_s, shift_s;
        bool ended = false;
        double t_s = 0, value = 0;
    };
    /// The cam in another file.
    struct CamFile {
        CamGuess cam;
        RowReader reader;
        EdgeFinder finder;
        std::deque<double> edge_s; ///< Found and not yet given.
        bool ended = false;
    };
    bool read_row();
    void open_cam(const CamGuess &cam);
    void find_cam_edge();
    void take_edges();
    void push(RecordedEvent::Kind kind, double time, int input, double value) { waiting_.push({kind, time * unit_s_, input, value}); }
    void step(OtherFile &file);
    void open(const SensorSource &sensor);

    RowReader reader_;
    bool is_edge_times_, has_cam_, has_home_, cam_rising_, home_rising_, crank_rising_;
    std::size_t crank_column_, cam_column_, home_column_;
    double unit_s_, origin_s_ = 0, newest_edge_s_ = 0;
    EdgeFinder crank_, cam_, home_;
    AddedTooth added_;
    std::vector<double> edges_;
    std::vector<SensorSource> columns_;
    std::vector<double> last_reading_;
    std::vector<std::unique_ptr<OtherFile>> files_;
    std::unique_ptr<CamFile> cam_file_;
    std::priority_queue<RecordedEvent, std::vector<RecordedEvent>, Later> waiting_;
    bool ended_ = false;
};

} // namespace sixdeg
