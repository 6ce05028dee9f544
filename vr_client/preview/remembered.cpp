#include "vr_client/preview/remembered.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "stereo/base/files.h"
#include "stereo/base/user_folders.h"

namespace farshade {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMost_bytes = 1 << 16;
constexpr std::uint64_t kLargestSide_px = 16384;

tl::unexpected<Error> wrong(const std::string& name, const char* wanted) {
  return fail(Fault::Malformed, "'" + name + "' is not " + wanted);
}

/// Reads `name` into `value` if it is there.
Expected<void> read(const json& object, const char* name, bool& value) {
  const auto found = object.find(name);
  if (found == object.end()) return {};
  if (!found->is_boolean()) return wrong(name, "true or false");
  value = found->get<bool>();
  return {};
}

Expected<void> read(const json& object, const char* name, double& value) {
  const auto found = object.find(name);
  if (found == object.end()) return {};
  if (!found->is_number()) return wrong(name, "a number");
  const auto number = found->get<double>();
  if (!(number >= 0 && number <= kMostPictureShare)) return wrong(name, "within 0 to 0.75");
  value = number;
  return {};
}

Expected<void> read(const json& object, const char* name, Overlay& value) {
  const auto found = object.find(name);
  if (found == object.end()) return {};
  const auto* const text = found->get_ptr<const std::string*>();
  const auto* const overlay =
      std::ranges::find_if(kOverlays, [&](Overlay one) { return text != nullptr && *text == name_of(one); });
  if (overlay == kOverlays.end()) return wrong(name, "the name of an overlay");
  value = *overlay;
  return {};
}

Expected<void> read(const json& object, const char* name, std::optional<Extent>& value) {
  const auto found = object.find(name);
  if (found == object.end()) return {};
  const auto is_side = [](const json& side) {
    return side.is_number_unsigned() && side.get<std::uint64_t>() >= 1 &&
           side.get<std::uint64_t>() <= kLargestSide_px;
  };
  if (!found->is_array() || found->size() != 2 || !is_side((*found)[0]) || !is_side((*found)[1]))
    return wrong(name, "a width and a height within 1 to 16384");
  value = Extent{(*found)[0].get<std::uint32_t>(), (*found)[1].get<std::uint32_t>()};
  return {};
}

}  // namespace

std::string text_of(const Remembered& remembered) {
  json object;
  if (remembered.window) {
    json size = json::array();
    size.push_back(remembered.window->width);
    size.push_back(remembered.window->height);
    object["window"] = std::move(size);
  }
  object["panel"] = remembered.panel;
  object["overlay"] = name_of(remembered.overlay);
  object["picture_share"] = remembered.picture_share;
  return object.dump(2) + "\n";
}

Expected<Remembered> parse_remembered(std::string_view text) {
  const json object = json::parse(text, nullptr, false);
  if (!object.is_object()) return fail(Fault::Malformed, "it is no JSON object");
  Remembered result;
  Expected<void> done = read(object, "window", result.window);
  if (done) done = read(object, "panel", result.panel);
  if (done) done = read(object, "overlay", result.overlay);
  if (done) done = read(object, "picture_share", result.picture_share);
  if (!done) return tl::unexpected(done.error());
  return result;
}

std::filesystem::path remembered_path() {
  return state_folder() / "preview.json";
}

Expected<Remembered> load_remembered(const std::filesystem::path& path) {
  const Expected<std::vector<std::byte>> bytes = read_file(path, kMost_bytes);
  if (!bytes && bytes.error().fault == Fault::Missing) return Remembered{};
  if (!bytes) return tl::unexpected(bytes.error());
  Expected<Remembered> parsed =
      parse_remembered({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  if (!parsed) return fail(parsed.error().fault, path.string() + ": " + parsed.error().what);
  return parsed;
}

Expected<void> save_remembered(const std::filesystem::path& path, const Remembered& remembered) {
  if (auto made = make_folder(path.parent_path()); !made) return made;
  return write_file_atomically(path, text_of(remembered));
}

}  // namespace farshade
