/// SceneOffer: what a server tells a client about its scene before it sends a file: the files, and the
/// lighting of its command line. A client trusts nothing of it but the bounds below; the files must have the
/// promised hashes, and the lit scene the hash of the Welcome.
#pragma once

#include <string>
#include <vector>

#include "stereo/base/digest.h"
#include "stereo/base/expected.h"
#include "stereo/messages/refusal.h"
#include "stereo/scene/lighting.h"

namespace farshade {

inline constexpr std::size_t kMostSceneFiles = 4096;
inline constexpr std::uint64_t kMostScene_bytes = std::uint64_t{1} << 30;  ///< of all files together
inline constexpr std::size_t kMostOffer_bytes = std::size_t{1} << 20;

struct OfferedFile {
  std::string name;         ///< relative path (is_offered_name)
  std::uint64_t bytes = 0;  ///< at least 1
  Digest hash{};            ///< BLAKE2b-256
  friend bool operator==(const OfferedFile&, const OfferedFile&) = default;
};

struct SceneOffer {
  Lighting lighting{};
  std::vector<OfferedFile> files{};  ///< the scene's own file, then those that it names; no name twice
};

/// Whether a file of this name lies below every folder to which it is added: 1 to 1024 bytes, at most 16
/// parts divided by `/`, each of 1 to 255 bytes and neither `.` nor `..`, no control characters.
[[nodiscard]] bool is_offered_name(std::string_view name);

[[nodiscard]] std::uint64_t total_bytes(const std::vector<OfferedFile>& files);

/// Identifies the files: names, sizes and hashes, but not the lighting.
[[nodiscard]] Digest digest_of(const std::vector<OfferedFile>& files);

/// Why these files cannot be offered, as a sentence: a bound above, or a name. Both sides ask.
[[nodiscard]] Expected<void> check_offered(const std::vector<OfferedFile>& files);

/// The offer passes check_offered.
[[nodiscard]] std::vector<std::byte> encode(const SceneOffer& offer);

/// Malformed, or as check_offered.
[[nodiscard]] Expected<SceneOffer> decode_offer(std::span<const std::byte> bytes);

}  // namespace farshade
