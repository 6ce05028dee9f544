/// SampleList: collects the rows of a head recording, then makes a recording of them: chooses what the file
/// does not state, leaves out bad rows, and judges whether the heads are plausible. All file formats use it.
#pragma once

#include "stereo/head/reader.h"
#include "stereo/head/rows.h"

namespace farshade {

/// What a file states itself or its format implies.
struct FileFacts {
  std::string_view file, format;
  double units_a_metre = 1.0;
  bool states_scale = false;  ///< the file says so, and no user
  TimeUnit usual_unit = TimeUnit::Nanoseconds;
  std::optional<TimeUnit> unit;                        ///< stated by the file
  QuaternionOrder order_read = QuaternionOrder::Wxyz;  ///< in which the rows were added
  bool states_order = false, states_axes = false;  ///< the order is certain; the axes are those of the stage
  double eye_distance_m = kDefaultEyeDistance_m;
  PerEye<EyeFov> fov = kDefaultFov;
};

class SampleList {
 public:
  /// A row in the file's units and axes. `stamp` must stay valid until finish. Normalises `rotation`. Refuses
  /// a row that load_head_recording leaves out.
  [[nodiscard]] Expected<void> add(rows::Place place, std::string_view stamp, const glm::dvec3& position,
                                   const glm::dquat& rotation);
  /// Counts a row that is no pose.
  void leave_out(Error why);

  /// The recording: of the samples, the longest subsequence with increasing stamps. Refuses as
  /// load_head_recording.
  [[nodiscard]] Expected<HeadRecording> finish(const FileFacts& facts, const HeadFileOptions& options) &&;

 private:
  struct Row {
    std::size_t line;
    std::string_view stamp;
    Rigid<Recorded, Head> pose;
  };
  [[nodiscard]] Expected<std::vector<HeadSample>> timed(const FileFacts& facts, TimeUnit unit);
  [[nodiscard]] std::string dropped_rows(std::size_t all) const;

  std::vector<Row> rows_;
  std::vector<double> stamps_;  ///< of rows_, in the file's unit
  std::size_t bad_ = 0, backward_ = 0;
  std::optional<Error> first_bad_;
};

}  // namespace farshade
