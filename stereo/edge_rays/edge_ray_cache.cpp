#include "stereo/edge_rays/edge_ray_cache.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <span>

#include "stereo/base/cache_file.h"
#include "stereo/base/check.h"
#include "stereo/base/digest.h"

namespace farshade {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

/// To be raised whenever make_light_buffer gives other buffers.
constexpr std::uint32_t kVersion = 2;

template <class T>
void add(Digester& digester, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  digester.add(std::as_bytes(std::span(&value, 1)));
}

void add(Digester& digester, const MapView& view) {
  add(digester, view.kind);
  for (const glm::dvec3& axis : {view.right, view.up, view.ahead, view.origin.v}) add(digester, axis);
  add(digester, view.texels);
  add(digester, view.side_px);
}

Digest key_of(const EdgeRayInput& input) {
  Digester digester;
  add(digester, kVersion);
  add(digester, input.most_words);
  add(digester, input.casters.origin.v);
  add(digester, std::uint64_t{input.casters.corners.size()});
  digester.add(std::as_bytes(std::span(input.casters.corners)));
  for (const bool has_holes : input.casters.has_holes) add(digester, has_holes);
  for (const EdgeRayData::Buffered& light : input.lights) add(digester, light.projection.view);
  return digester.finish();
}

/// A file is the key, a word for each light and the words of all buffers. The word of a light is the number
/// of its buffer's words; 0: it has none.
std::vector<std::byte> encode(const Digest& key, const EdgeRayData& data) {
  std::vector<std::byte> bytes(key.size() + (data.lights.size() + data.words.size()) * sizeof(std::uint32_t));
  std::span<std::byte> rest(bytes);
  const auto put = [&](std::span<const std::byte> from) {
    std::ranges::copy(from, rest.begin());
    rest = rest.subspan(from.size());
  };
  put(std::as_bytes(std::span(key)));
  for (std::size_t i = 0; i < data.lights.size(); ++i) {
    const std::size_t end =
        i + 1 < data.lights.size() ? data.lights[i + 1].projection.first_layer : data.words.size();
    const auto words = narrow<std::uint32_t>(end - data.lights[i].projection.first_layer);
    put(std::as_bytes(std::span(&words, 1)));
  }
  put(std::as_bytes(std::span(data.words)));
  return bytes;
}

/// The words of all buffers, after their numbers of words for each light. Malformed if they cannot be read.
Expected<std::vector<std::uint32_t>> words_in(const Digest& key, const EdgeRayInput& input,
                                              std::span<const std::byte> bytes) {
  const std::size_t words = bytes.size() / sizeof(std::uint32_t);
  if (bytes.size() < key.size() + input.lights.size() * sizeof(std::uint32_t) ||
      bytes.size() % sizeof(std::uint32_t) != 0)
    return fail(Fault::Malformed, "its length is wrong");
  if (std::memcmp(bytes.data(), key.data(), key.size()) != 0)
    return fail(Fault::Malformed, "it is of another version or scene");
  std::vector<std::uint32_t> result(words - key.size() / sizeof(std::uint32_t));
  std::memcpy(result.data(), &bytes[key.size()], result.size() * sizeof(std::uint32_t));
  return result;
}

Expected<EdgeRayData> decode(const Digest& key, const EdgeRayInput& input, std::span<const std::byte> bytes) {
  const Expected<std::vector<std::uint32_t>> words = words_in(key, input, bytes);
  if (!words) return tl::unexpected(words.error());
  EdgeRayData data = without_buffers(input);
  const std::span<const std::uint32_t> counts = std::span(*words).first(data.lights.size());
  std::span<const std::uint32_t> rest = std::span(*words).subspan(data.lights.size());
  if (rest.size() > input.most_words) return fail(Fault::Malformed, "its length is wrong");
  data.words.assign(rest.begin(), rest.end());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    LightShadowMaps& projection = data.lights[i].projection;
    projection.first_layer = narrow<std::uint32_t>(data.words.size() - rest.size());
    if (counts[i] == 0) {
      projection.view.kind = FARSHADE_MAP_NONE;
      continue;
    }
    if (projection.view.kind == FARSHADE_MAP_NONE || counts[i] > rest.size() ||
        !is_light_buffer(rest.first(counts[i]), projection.view, input.casters))
      return fail(Fault::Malformed, "it has no light buffers");
    rest = rest.subspan(counts[i]);
  }
  if (!rest.empty()) return fail(Fault::Malformed, "its length is wrong");
  return data;
}

std::filesystem::path file_of(const std::filesystem::path& folder, const Digest& key) {
  constexpr std::size_t kNameBytes = 16;
  return folder / (cache_name(std::span(key).first(kNameBytes)) + ".lights");
}

}  // namespace

std::filesystem::path edge_ray_file(const std::filesystem::path& folder, const EdgeRayInput& input) {
  return file_of(folder, key_of(input));
}

CachedEdgeRayData cached_edge_ray_data(const EdgeRayInput& input, const std::filesystem::path& folder,
                                       const std::stop_token& stop) {
  const Digest key = key_of(input);
  const std::filesystem::path path = file_of(folder, key);
  const std::uint64_t most_bytes = (1 << 20) + input.most_words * sizeof(std::uint32_t);
  CachedEdgeRayData result;
  Expected<EdgeRayData> kept = read_cache_file(path, most_bytes).and_then([&](const auto& content) {
    return decode(key, input, content);
  });
  if (kept) return {std::move(*kept), true};
  if (kept.error().fault == Fault::Malformed)
    result.trouble = path.string() + " is replaced: " + kept.error().what;
  else if (kept.error().fault != Fault::Missing)
    result.trouble = kept.error().what;
  result.data = make_edge_ray_data(input, stop);
  if (stop.stop_requested()) return result;
  if (const auto written = write_cache_file(path, encode(key, result.data)); !written)
    result.trouble = written.error().what;
  return result;
}

}  // namespace farshade
