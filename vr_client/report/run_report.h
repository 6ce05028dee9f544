/// RunReport: measures the frames of a run, writes pictures of some of them, and finally writes the summary.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/dump.h"
#include "vr_client/report/frame_log.h"
#include "vr_client/report/measure.h"

namespace farshade {

/// `frame_NNNN_left.png` and `_right.png`.
[[nodiscard]] Expected<void> write_shown(const std::filesystem::path& folder, FrameId frame,
                                         const PerEye<Image<Rgb8>>& shown);

/// `worst_NNNN_EYE_{shown,reference,difference_x8,source}.png`, and `worst.png` with all of them in
/// one row per eye. The source picture needs a report.
[[nodiscard]] Expected<void> write_measured(const std::filesystem::path& folder, const MeasuredFrame& frame);

/// When frames are compared with their references.
enum class Compare : std::uint8_t {
  AtOnce,       ///< before the next frame begins
  AfterTheRun,  ///< so that no display time is missed meanwhile; as many frames as kMostKept_bytes can hold,
                ///< and so many dumps
};
inline constexpr std::uint64_t kMostKept_bytes = std::uint64_t{1} << 29;

struct RunReportOptions {
  std::filesystem::path out;
  std::uint32_t frame_count = 0;      ///< frames that the run will show; pictures are spread evenly over them
  std::uint32_t reference_every = 1;  ///< 0 = never
  std::uint32_t pictures = 4;
  std::vector<std::uint32_t> dump;
  Compare compare = Compare::AtOnce;

  /// True if the shading pass must report, because frames will be measured.
  [[nodiscard]] bool measures_any() const { return reference_every > 0 || !dump.empty(); }
};

class RunReport {
 public:
  /// `renderer` has drawn the frames. It may be replaced between two frames, and be null when the device is
  /// lost for good. `reference` may be null only if `options` measure no frame.
  RunReport(RunReportOptions options, const std::unique_ptr<Renderer>& renderer, Reference* reference);

  void watch(const FrameView& view);

  /// The run ended before its last frame: summary.csv says so in a row of its own.
  void mark_interrupted() { interrupted_ = true; }

  /// The first failure to write a file. No more pictures and dumps are written after it.
  [[nodiscard]] const std::optional<Error>& failed() const { return failed_; }
  [[nodiscard]] const FrameLog& log() const { return log_; }
  /// The last frame that was measured.
  [[nodiscard]] const MeasuredFrame& measured() const { return current_; }

  /// Compares the frames that have waited for it, if there is a renderer.
  void compare_kept();
  /// Compares the frames that still wait. Writes summary.csv and frames.csv, and then the pictures, so that a
  /// full disk costs pictures and not the numbers. failed() tells whether all were written.
  void finish();

 private:
  [[nodiscard]] bool is_pictured(FrameId frame) const;
  [[nodiscard]] bool is_dumped(FrameId frame) const;
  [[nodiscard]] bool is_measured(FrameId frame) const;
  struct Taken;
  void keep(Taken taken);
  void compare(Taken taken);
  void picture(const FrameView& view, const std::optional<Taken>& taken);
  void keep(Expected<void> done);

  RunReportOptions options_;
  const std::unique_ptr<Renderer>& renderer_;
  Reference* reference_;
  FrameLog log_;
  std::optional<FrameId> counted_;  ///< the server frame that was logged last
  MeasuredFrame current_;
  std::optional<MeasuredFrame> worst_;
  double worst_error_ = -1;
  bool interrupted_ = false;
  std::uint32_t every_;  ///< every so manyth frame is measured; 0: none
  /// A shown frame that will be compared.
  struct Taken {
    std::size_t record;  ///< in the log
    FrameToMeasure frame;
    std::optional<Dump> dump;
  };
  std::vector<Taken> kept_;  ///< to be compared after the run
  std::uint64_t kept_dump_bytes_ = 0;
  struct KeptPicture {
    FrameId frame;
    PerEye<Image<Rgb8>> shown;
  };
  std::vector<KeptPicture> kept_pictures_;  ///< to be written after the run
  std::uint64_t kept_picture_bytes_ = 0;
  bool awaits_picture_ = false;  ///< the next frame that shows an answer is written
  std::optional<Error> failed_;
};

}  // namespace farshade
