#include "vr_client/preview/remembered.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "stereo/base/files.h"
#include "stereo/base/user_folders.h"

namespace farshade {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMost_bytes = 1 << 16;
constexpr std::uint64_t kLargestSide_px = 16384;

/// A value of the file.
struct Field {
  const char *name, *wanted;
  bool (*take)(const json& from, Remembered& into);  ///< False: it is not what is wanted
};

bool is_side(const json& side) {
  return side.is_number_unsigned() && side >= 1 && side <= kLargestSide_px;
}

const Field kFields[]{{"window", "a width and a height within 1 to 16384",
                       [](const json& from, Remembered& into) {
                         if (!from.is_array() || from.size() != 2 || !is_side(from[0]) || !is_side(from[1]))
                           return false;
                         into.window = {from[0].get<std::uint32_t>(), from[1].get<std::uint32_t>()};
                         return true;
                       }},
                      {"panel", "true or false",
                       [](const json& from, Remembered& into) {
                         if (from.is_boolean()) into.panel = from.get<bool>();
                         return from.is_boolean();
                       }},
                      {"overlay", "the name of an overlay",
                       [](const json& from, Remembered& into) {
                         const auto found = std::ranges::find_if(
                             kOverlays, [&](Overlay one) { return from == name_of(one); });
                         if (found != kOverlays.end()) into.overlay = *found;
                         return found != kOverlays.end();
                       }},
                      {"picture_share", "a number within 0 to 0.75", [](const json& from, Remembered& into) {
                         const double number = from.is_number() ? from.get<double>() : -1;
                         const bool fits = number >= 0 && number <= kMostPictureShare;
                         if (fits) into.picture_share = number;
                         return fits;
                       }}};

}  // namespace

std::string text_of(const Remembered& remembered) {
  json object;
  if (remembered.window)
    object["window"] = json::array({remembered.window->width, remembered.window->height});
  object["panel"] = remembered.panel;
  object["overlay"] = name_of(remembered.overlay);
  object["picture_share"] = remembered.picture_share;
  return object.dump(2) + "\n";
}

Expected<Remembered> parse_remembered(std::string_view text) {
  const json object = json::parse(text, nullptr, false);
  if (!object.is_object()) return fail(Fault::Malformed, "it is no JSON object");
  Remembered result;
  for (const Field& field : kFields)
    if (const auto found = object.find(field.name); found != object.end() && !field.take(*found, result))
      return fail(Fault::Malformed, fmt::format("'{}' is not {}", field.name, field.wanted));
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
