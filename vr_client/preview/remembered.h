/// Remembered: what the preview keeps from one run to the next, as JSON in the user's state folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "stereo/base/expected.h"
#include "stereo/base/extent.h"
#include "vr_client/report/overlays.h"

namespace farshade {

/// Share of the shaded picture that shines through an overlay.
inline constexpr double kDefaultPictureShare = 0.25, kMostPictureShare = 0.75;

struct Remembered {
  std::optional<Extent> window;  ///< its last size, pixels
  bool panel = true;
  Overlay overlay = Overlay::None;
  double picture_share = kDefaultPictureShare;
  friend bool operator==(const Remembered&, const Remembered&) = default;
};

[[nodiscard]] std::string text_of(const Remembered& remembered);

/// Malformed if the text is no JSON object, or if a value has the wrong type or is out of range. A value that
/// is not there keeps its default; unknown ones are ignored.
[[nodiscard]] Expected<Remembered> parse_remembered(std::string_view text);

/// preview.json in the state folder (user_folders.h).
[[nodiscard]] std::filesystem::path remembered_path();

/// The defaults if there is no file; otherwise as parse_remembered, with the path in the error.
[[nodiscard]] Expected<Remembered> load_remembered(const std::filesystem::path& path);

/// Makes the folder if necessary.
[[nodiscard]] Expected<void> save_remembered(const std::filesystem::path& path, const Remembered& remembered);

}  // namespace farshade
