#include "stereo/fetch/scene_offer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "stereo/messages/bytes.h"
#include "stereo/messages/frame_fields.h"

namespace farshade {
namespace {

constexpr std::size_t kMostName_bytes = 1024, kMostNamePart_bytes = 255, kMostNameParts = 16;
constexpr float kMostIntensity = 1e30f;

// ---- fields: the same function writes and reads

bool real(auto& io, float& value) {
  double wide = value;
  if (!io.f64(wide) || !(std::abs(wide) <= double{std::numeric_limits<float>::max()})) return false;
  value = static_cast<float>(wide);
  return true;
}

bool real(auto& io, std::optional<float>& value) {
  std::uint8_t is_there = value.has_value();
  float number = value.value_or(0.0f);
  if (!io.u8(is_there) || is_there > 1 || !real(io, number)) return false;
  value = is_there == 1 ? std::optional(number) : std::nullopt;
  return true;
}

bool place(auto& io, glm::dvec3& v) {
  return io.f64(v.x) && io.f64(v.y) && io.f64(v.z);
}

bool light_fields(auto& io, AddedLight& light) {
  LightSource& source = light.source;
  return io.code(source.kind) && real(io, source.intensity.x) && real(io, source.intensity.y) &&
         real(io, source.intensity.z) && real(io, source.range_m) && real(io, source.inner_cone_rad) &&
         real(io, source.outer_cone_rad) && place(io, light.position.v) && place(io, light.direction.v);
}

/// Calls `one` for each element of a list that has at most `most` of them.
bool each_field(auto& io, auto& list, std::size_t most, auto one) {
  auto count = static_cast<std::uint16_t>(list.size());
  if (!io.u16(count) || count > most) return false;
  list.resize(count);
  return std::ranges::all_of(list, [&](auto& element) { return one(element); });
}

bool character(auto& io, char& c) {
  auto byte = static_cast<std::uint8_t>(c);
  if (!io.u8(byte)) return false;
  c = static_cast<char>(byte);
  return true;
}

bool text(auto& io, std::string& value) {
  return each_field(io, value, kMostName_bytes, [&](char& c) { return character(io, c); });
}

bool choice_fields(auto& io, SceneChoice& choice) {
  constexpr std::uint8_t kScene = 1, kAnimation = 2;  // older programs know no animation
  auto has =
      static_cast<std::uint8_t>((choice.scene ? kScene : 0) | (choice.animation.empty() ? 0 : kAnimation));
  std::uint32_t scene = choice.scene.value_or(0);
  if (!io.u8(has) || has > (kScene | kAnimation) || !io.u32(scene)) return false;
  choice.scene = (has & kScene) != 0 ? std::optional(scene) : std::nullopt;
  return text(io, choice.camera) && text(io, choice.variant) &&
         ((has & kAnimation) == 0 || (text(io, choice.animation) && !choice.animation.empty()));
}

bool lighting_fields(auto& io, Lighting& lighting) {
  return choice_fields(io, lighting.choice) &&
         each_field(io, lighting.lights, kMaxLights,
                    [&](AddedLight& light) { return light_fields(io, light); }) &&
         real(io, lighting.ambient) && real(io, lighting.exposure);
}

bool file_fields(auto& io, OfferedFile& file) {
  return text(io, file.name) && io.u64(file.bytes) && io.array(file.hash);
}

bool files_fields(auto& io, std::vector<OfferedFile>& files) {
  return each_field(io, files, kMostSceneFiles, [&](OfferedFile& file) { return file_fields(io, file); });
}

// ---- ranges, as those of the command line (stereo/options)

bool is_within(const std::optional<float>& value, float low, float high) {
  return !value || (*value >= low && *value <= high);
}

bool is_light(const AddedLight& light) {
  const LightSource& source = light.source;
  for (int i = 0; i < 3; ++i)
    if (!(source.intensity[i] >= 0 && source.intensity[i] <= kMostIntensity) ||
        !(std::abs(light.position.v[i]) <= kMaxCoordinate_m) || !std::isfinite(light.direction.v[i]))
      return false;
  return source.kind <= LightKind::Directional &&
         std::abs(glm::length(light.direction.v) - 1) < kMaxOffUnit &&
         (!source.range_m || *source.range_m > 0) && source.inner_cone_rad >= 0 &&
         source.outer_cone_rad >= source.inner_cone_rad &&
         source.outer_cone_rad <= std::numbers::pi_v<float> / 2 + 1e-6f;
}

bool is_lighting(const Lighting& lighting) {
  return std::ranges::all_of(lighting.lights, is_light) && is_within(lighting.ambient, 0, 1e6f) &&
         is_within(lighting.exposure, 1e-12f, 1e12f);
}

}  // namespace

bool is_offered_name(std::string_view name) {
  if (name.empty() || name.size() > kMostName_bytes) return false;
  if (std::ranges::any_of(name, [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; }))
    return false;
  if (std::ranges::count(name, '/') >= static_cast<std::ptrdiff_t>(kMostNameParts)) return false;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    const std::string_view part = name.substr(begin, end - begin);
    if (part.empty() || part.size() > kMostNamePart_bytes || part == "." || part == "..") return false;
    begin = end + 1;
  }
  return true;
}

std::uint64_t total_bytes(const std::vector<OfferedFile>& files) {
  std::uint64_t sum = 0;
  for (const OfferedFile& file : files) sum += file.bytes;
  return sum;
}

Digest digest_of(const std::vector<OfferedFile>& files) {
  std::vector<std::byte> bytes;
  ByteWriter io(bytes);
  std::vector<OfferedFile> written = files;
  files_fields(io, written);
  return digest_of(bytes);
}

Expected<void> check_offered(const std::vector<OfferedFile>& files) {
  if (files.empty() || files.size() > kMostSceneFiles)
    return fail(Fault::OutOfRange, "the scene has " + std::to_string(files.size()) + " files; 1 to " +
                                       std::to_string(kMostSceneFiles) + " can be sent");
  std::set<std::string_view> names;
  std::uint64_t left = kMostScene_bytes;
  for (const OfferedFile& file : files) {
    if (!is_offered_name(file.name))
      return fail(Fault::Malformed,
                  "a file of the scene has a name that leads out of its folder or cannot be "
                  "used in every folder");
    if (!names.insert(file.name).second)
      return fail(Fault::Malformed, "the scene names '" + file.name + "' twice");
    if (file.bytes == 0) return fail(Fault::Malformed, "'" + file.name + "' of the scene is empty");
    if (file.bytes > left)
      return fail(Fault::OutOfRange, "the scene's files have more than " + std::to_string(kMostScene_bytes) +
                                         " bytes together: copy them to the client and give --scene");
    left -= file.bytes;
  }
  return {};
}

std::vector<std::byte> encode(const SceneOffer& offer) {
  check(check_offered(offer.files).has_value(), "the files can be offered");
  std::vector<std::byte> bytes;
  ByteWriter io(bytes);
  SceneOffer written = offer;
  lighting_fields(io, written.lighting);
  files_fields(io, written.files);
  return bytes;
}

Expected<SceneOffer> decode_offer(std::span<const std::byte> bytes) {
  SceneOffer offer;
  ByteReader io(bytes);
  if (!lighting_fields(io, offer.lighting) || !files_fields(io, offer.files) || io.remaining() > 0 ||
      !is_lighting(offer.lighting))
    return fail(Fault::Malformed, "the server's offer of its scene cannot be read");
  if (const Expected<void> fine = check_offered(offer.files); !fine) return tl::unexpected(fine.error());
  for (AddedLight& light : offer.lighting.lights) light.source.name = "light of the server";
  return offer;
}

}  // namespace farshade
