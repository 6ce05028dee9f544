#include "tests/stability/dump.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/image_reader.h"

namespace farshade::stability {
namespace {

using nlohmann::json;

View view_of(const json& described) {
  const json &pose = described["stage_from_eye"], &fov = described["fov_rad"];
  const auto p = pose["position_m"].get<std::array<double, 3>>();
  const auto q = pose["rotation_xyzw"].get<std::array<double, 4>>();
  const auto size = described["size_px"].get<std::array<std::uint32_t, 2>>();
  return {{glm::dquat(q[3], q[0], q[1], q[2]), {p[0], p[1], p[2]}},
          {fov["left"], fov["right"], fov["up"], fov["down"]},
          {size[0], size[1]}};
}

StereoView views_of(const json& described) {
  return {view_of(described["left"]), view_of(described["right"])};
}

/// Stores the value, or the error.
template <class T>
void take(Expected<T> read, T& into, std::optional<Error>& failed) {
  if (read)
    into = std::move(*read);
  else if (!failed)
    failed = read.error();
}

}  // namespace

Expected<Dump> read_dump(const std::filesystem::path& frame_folder) {
  std::ifstream file(frame_folder / "views.json");
  if (!file) return fail(Fault::Missing, "no dump in " + frame_folder.string());
  const json described = json::parse(file, nullptr, false);
  if (described.is_discarded()) return fail(Fault::Malformed, "views.json is no JSON");
  if (described["traced"].is_null()) return fail(Fault::Missing, "the frame was shown without any mask");
  const auto time = [](const json& view, const char* key) { return time_from_ns(view[key]); };
  Dump dump{.shown = views_of(described["shown"]["views"]),
            .traced = views_of(described["traced"]["views"]),
            .scene_time = time(described["shown"], "scene_time_ns"),
            .eyes = {}};
  dump.traced_scene_time = dump.scene_time - (time(described["shown"], "display_time_ns") -
                                              time(described["traced"], "display_time_ns"));
  std::optional<Error> failed;
  for (const Side side : kSides) {
    DumpedEye& eye = dump.eyes[index_of(side)];
    const auto path = [&](const char* what) {
      return frame_folder / (std::string(name_of(side)) + "_" + what);
    };
    take(read_png16(path("mask_traced.png")), eye.mask_traced, failed);
    take(read_png16(path("mask_shown.png")), eye.mask_shown, failed);
    take(read_png16(path("source.png")), eye.source, failed);
    take(read_pfm(path("distance.pfm")), eye.distance_m, failed);
    take(read_pfm(path("lookup_x.pfm")), eye.lookup_x, failed);
    take(read_pfm(path("lookup_y.pfm")), eye.lookup_y, failed);
    take(read_png(path("shown.png")), eye.shown, failed);
  }
  if (failed) return tl::unexpected(*failed);
  return dump;
}

std::size_t count_not_finite(const Dump& dump) {
  std::size_t count = 0;
  for (const DumpedEye& eye : dump.eyes)
    for (const Image<float>* image : {&eye.distance_m, &eye.lookup_x, &eye.lookup_y})
      count += static_cast<std::size_t>(
          std::ranges::count_if(image->pixels, [](float value) { return !std::isfinite(value); }));
  return count;
}

}  // namespace farshade::stability
