#include "vr_client/report/dump.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "stereo/base/files.h"
#include "stereo/image/codec.h"

namespace farshade {
namespace {

using nlohmann::json;

json vector3(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

json view_json(const View& view) {
  const glm::dquat& q = view.stage_from_eye.rotation;
  return {
      {"stage_from_eye",
       {{"position_m", vector3(view.stage_from_eye.translation)}, {"rotation_xyzw", {q.x, q.y, q.z, q.w}}}},
      {"fov_rad",
       {{"left", view.fov.left_rad},
        {"right", view.fov.right_rad},
        {"up", view.fov.up_rad},
        {"down", view.fov.down_rad}}},
      {"size_px", {view.size.width, view.size.height}}};
}

json views_json(const StereoView& views) {
  return {{"left", view_json(views[0])}, {"right", view_json(views[1])}};
}

json light_json(const Light& light) {
  constexpr std::array kinds{"point", "spot", "directional"};
  return {{"kind", kinds[static_cast<std::size_t>(light.kind)]},
          {"stage_position_m", vector3(light.position.v)},
          {"stage_direction", vector3(light.direction.v)},
          {"intensity", vector3(light.intensity)},
          {"range_m", light.range_m},
          {"inner_cone_rad", light.inner_cone_rad},
          {"outer_cone_rad", light.outer_cone_rad}};
}

json describe(const FrameView& view) {
  json described{{"shown",
                  {{"frame", view.shown.frame.value},
                   {"display_time_ns", ns_of(view.shown.display_time)},
                   {"scene_time_ns", ns_of(view.shown.scene_time)},
                   {"views", views_json(view.shown.views)}}},
                 {"light_set_revision", view.state.light_set.revision.value},
                 {"exposure", view.state.light_set.exposure.factor()},
                 {"lights", json::array()},
                 {"traced", nullptr}};
  for (const Light& light : view.state.light_set.lights) described["lights"].push_back(light_json(light));
  if (!view.masks.empty())
    described["traced"] = {{"frame", view.masks[0].frame.value},
                           {"display_time_ns", ns_of(view.masks[0].display_time)},
                           {"views", views_json(view.masks[0].views)}};
  return described;
}

Image<std::uint16_t> sources_of(const ShownReport& report) {
  Image<std::uint16_t> image(report.mask.size());
  std::copy(report.sources.begin(), report.sources.end(), image.pixels.begin());
  return image;
}

/// One coordinate of each pixel's surface point in the view of its source; 0 without a source.
Image<float> lookup_of(const ShownReport& report, std::size_t axis) {
  Image<float> image(report.mask.size());
  for (std::size_t i = 0; i < report.positions.size(); ++i) {
    image.pixels[i] = is_mask(report.sources[i]) ? report.positions[i][axis] : 0.0f;
  }
  return image;
}

Image<std::uint16_t> low_bits(const EyeMask& mask) {
  Image<std::uint16_t> image(mask.size());
  for (std::uint32_t y = 0; y < image.size.height; ++y)
    for (std::uint32_t x = 0; x < image.size.width; ++x)
      image.at(x, y) = static_cast<std::uint16_t>(mask.word(x, y) & 0xFFFFu);
  return image;
}

}  // namespace

std::uint64_t Dump::bytes() const {
  std::uint64_t sum = views_json.size();
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    sum +=
        (traced ? (*traced)[eye].bytes().size() : 0) + std::as_bytes(std::span(distance[eye].pixels)).size();
  return sum;
}

Dump dump_of(const FrameView& view, PerEye<Image<float>> distance) {
  Dump dump{view.shown.frame, std::nullopt, std::move(distance), describe(view).dump(2) + "\n"};
  if (!view.masks.empty()) dump.traced = view.masks[0].masks;
  return dump;
}

Expected<void> write_dump(const std::filesystem::path& folder, const Dump& dump, const MeasuredFrame& frame) {
  const std::filesystem::path inside = folder / fmt::format("frame_{:04}", dump.frame.value);
  if (auto made = make_folder(inside); !made) return made;
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    const auto path = [&](const char* what) { return inside / fmt::format("{}_{}", name_of(side), what); };
    Expected<void> done;
    if (dump.traced) done = write_png16(path("mask_traced.png"), low_bits((*dump.traced)[eye]));
    if (done) done = write_png16(path("mask_shown.png"), low_bits(frame.report[eye].mask));
    if (done) done = write_png16(path("source.png"), sources_of(frame.report[eye]));
    if (done) done = write_pfm(path("lookup_x.pfm"), lookup_of(frame.report[eye], 0));
    if (done) done = write_pfm(path("lookup_y.pfm"), lookup_of(frame.report[eye], 1));
    if (done) done = write_pfm(path("distance.pfm"), dump.distance[eye]);
    if (done) done = write_png(path("shown.png"), frame.shown[eye]);
    if (done) done = write_png(path("reference.png"), frame.reference[eye]);
    if (!done) return done;
  }
  return write_file_atomically(inside / "views.json", dump.views_json);
}

}  // namespace farshade
