/// Verdict: whether a run's pictures are right and whether its work and traffic fit the display, in three
/// lines.
#pragma once

#include <optional>
#include <string>

#include "vr_client/report/frame_log.h"

namespace farshade {

enum class Budget : std::uint8_t {
  Kept,       ///< in 99 % of the frames or more
  OftenKept,  ///< the median keeps it
  Exceeded,
};

/// Work against the time that there is for it.
struct TimeUse {
  double median_ms = 0, budget_ms = 0;
  double late_share = 0;  ///< the share of frames, or of answers, that take longer than the budget
  double frames = 1;      ///< display frames in the budget: more than 1 if not every frame requests an answer

  [[nodiscard]] Budget budget() const;
};

struct PictureError {
  Side eye{};  ///< the one with the lower median of the PSNR
  Spread psnr_db;
  double flip = 0, ssim = 0;                 ///< medians
  std::optional<Spread> mask_error_percent;  ///< empty in modes that show a picture of the server
};

/// Means over all frames with a connection.
struct ByteUse {
  double down_bytes = 0, up_bytes = 0;    ///< a frame
  double down_mbit_s = 0, up_mbit_s = 0;  ///< at the display's rate
  /// Stated by the user, or, down, measured by the server, median. No value: unknown.
  std::optional<PathRate> path;
  bool is_stated = false;
  double view_size_percent = 100;  ///< of requested views, median; less if the path is too slow

  /// Also up, where a path of unknown rate carries as much as down. Kept if neither is known.
  [[nodiscard]] Budget budget() const;
};

struct Verdict {
  std::optional<PictureError> picture;  ///< no value if no frame was compared
  std::optional<TimeUse> client, server;
  std::optional<ByteUse> bytes;  ///< no value without a connection
  double missed_share = 0;       ///< of all display times
  bool is_valid = true;          ///< the head is outside of geometry in at least half of its poses

  /// It is valid; client, server and bytes fit, and at most 1 % of the display times were missed.
  [[nodiscard]] bool fits() const;
};

/// Of the worse eye. No value if no frame was compared.
[[nodiscard]] std::optional<PictureError> picture_error(const FrameLog& log);

[[nodiscard]] Verdict verdict_of(const FrameLog& log, const RunTotals& totals);

/// "picture: ...", "time: ..." and "bytes: ...", each with its line feed.
[[nodiscard]] std::string in_words(const Verdict& verdict, const RunTotals& totals);

}  // namespace farshade
