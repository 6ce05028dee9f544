#include "stereo/lod/level_cache.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "stereo/base/cache_file.h"
#include "stereo/base/check.h"

namespace farshade {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

/// To be raised whenever make_levels gives other levels.
constexpr std::uint32_t kVersion = 3;
constexpr std::array<char, 8> kMagic{'F', 'A', 'R', 'L', 'E', 'V', 'E', 'L'};

/// The beginning of a file. After it, for each mesh, its levels and triangles.
struct Header {
  std::array<char, 8> magic = kMagic;
  std::uint32_t version = kVersion, meshes = 0;
  SceneHash scene{};
  friend bool operator==(const Header&, const Header&) = default;
};
static_assert(sizeof(Header) == 48 && std::has_unique_object_representations_v<Header>);
static_assert(sizeof(DetailLevel) == 12);

Header header_of(const Scene& scene) {
  return {.meshes = narrow<std::uint32_t>(scene.meshes.size()), .scene = scene.hash};
}

void append_bytes(std::vector<std::byte>& bytes, const void* from, std::size_t count) {
  const std::size_t at = bytes.size();
  bytes.resize(at + count);
  if (count > 0) std::memcpy(&bytes[at], from, count);
}

template <class T>
void append(std::vector<std::byte>& bytes, const T& value) {
  append_bytes(bytes, &value, sizeof value);
}

template <class T>
void append(std::vector<std::byte>& bytes, const std::vector<T>& list) {
  append(bytes, narrow<std::uint32_t>(list.size()));
  append_bytes(bytes, list.data(), list.size() * sizeof(T));
}

/// Takes values from the front of a file. After a failure every further value is empty.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  T value() {
    T result{};
    if (const auto raw = take(sizeof(T)); !raw.empty()) std::memcpy(&result, raw.data(), sizeof(T));
    return result;
  }
  template <class T>
  std::vector<T> list() {
    const std::size_t count = value<std::uint32_t>();
    if (count > bytes_.size() / sizeof(T)) failed_ = true;
    if (failed_ || count == 0) return {};
    std::vector<T> result(count);
    std::memcpy(result.data(), take(count * sizeof(T)).data(), count * sizeof(T));
    return result;
  }
  [[nodiscard]] bool is_complete() const { return !failed_ && bytes_.empty(); }

 private:
  std::span<const std::byte> take(std::size_t count) {
    failed_ |= count > bytes_.size();
    if (failed_) return {};
    const auto front = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return front;
  }

  std::span<const std::byte> bytes_;
  bool failed_ = false;
};

/// Are these levels that the mesh can have: successive, coarser and coarser, over its own vertices?
bool fit(const Mesh& mesh, const MeshLevels& levels) {
  std::size_t next = 0, before = mesh.triangles.size();
  float error = 0;
  for (const DetailLevel& level : levels.levels) {
    if (level.first != next || level.count == 0 || level.count >= before || !(level.error >= error))
      return false;
    next += level.count;
    before = level.count;
    error = level.error;
  }
  const auto vertices = narrow<std::uint32_t>(mesh.positions.size());
  return next == levels.triangles.size() && std::ranges::all_of(levels.triangles, [&](const glm::uvec3& t) {
           return t.x < vertices && t.y < vertices && t.z < vertices;
         });
}

}  // namespace

std::filesystem::path level_file(const std::filesystem::path& folder, const SceneHash& scene) {
  constexpr std::size_t kNameBytes = 16;
  return folder / (cache_name(std::span(scene).first(kNameBytes)) + ".levels");
}

std::vector<std::byte> encode_levels(const Scene& scene, const SceneLevels& levels) {
  check_eq(levels.size(), scene.meshes.size(), "the levels are the scene's");
  std::vector<std::byte> bytes;
  append(bytes, header_of(scene));
  for (const MeshLevels& mesh : levels) {
    append(bytes, mesh.levels);
    append(bytes, mesh.triangles);
  }
  return bytes;
}

Expected<SceneLevels> decode_levels(const Scene& scene, std::span<const std::byte> bytes) {
  Reader reader(bytes);
  if (reader.value<Header>() != header_of(scene))
    return fail(Fault::Malformed, "it is of another version or scene");
  SceneLevels levels(scene.meshes.size());
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i].levels = reader.list<DetailLevel>();
    levels[i].triangles = reader.list<glm::uvec3>();
    if (!fit(scene.meshes[i], levels[i])) return fail(Fault::Malformed, "its levels do not fit the meshes");
  }
  if (!reader.is_complete()) return fail(Fault::Malformed, "its length is wrong");
  return levels;
}

CachedLevels cached_levels(const Scene& scene, const std::filesystem::path& folder) {
  const std::filesystem::path path = level_file(folder, scene.hash);
  // Each level has at most 0.85 times the triangles of the one before.
  const std::uint64_t most_bytes = (1 << 20) + scene.triangle_count * 8 * sizeof(glm::uvec3);
  CachedLevels result;
  Expected<SceneLevels> kept = read_cache_file(path, most_bytes).and_then([&](const auto& content) {
    return decode_levels(scene, content);
  });
  if (kept) return {std::move(*kept), true};
  if (kept.error().fault == Fault::Malformed)
    result.trouble = path.string() + " is replaced: " + kept.error().what;
  else if (kept.error().fault != Fault::Missing)
    result.trouble = kept.error().what;
  result.levels = make_levels(scene);
  if (const auto written = write_cache_file(path, encode_levels(scene, result.levels)); !written)
    result.trouble = written.error().what;
  return result;
}

}  // namespace farshade
