#include "vr_client/preview/pixel_facts.h"

#include <fmt/format.h>

namespace farshade {
namespace {

std::string source_of(std::uint8_t source) {
  if (source == kSourceRays) return "the client's own rays: the newest mask does not have this point";
  if (source == kSourceUnknown) return "unknown: no mask has this point";
  if (is_face(source)) return "the cube mask";
  const bool beside = (source & kNeighbour) != 0;
  const auto index = static_cast<std::uint8_t>(source & ~kNeighbour);
  const std::size_t mask = mask_of(index);
  const char* const eye = index >= kOtherEye ? "the other eye" : "this eye";
  const std::string which =
      mask == 0 ? fmt::format("newest mask of {}", eye) : fmt::format("mask of {}, {} older", eye, mask);
  return beside ? which + ", nearest pixel on the surface" : which;
}

std::string visibility_of(const ShownReport& report, std::uint32_t light) {
  const auto bit_of = [&](const std::vector<std::uint32_t>& words) {
    return (words[light / 32] >> light % 32 & 1u) != 0;
  };
  const std::uint8_t k = report.visibility[light];
  std::string words = k == 255 ? "lit" : k == 0 ? "in shadow" : fmt::format("{:.0f} % lit", k / 2.55);
  if (bit_of(report.unknown)) words += ", unknown: a guess";
  if (bit_of(report.stale)) words += ", outdated";
  return words;
}

}  // namespace

std::vector<Fact> in_words(const PixelFacts& facts, const Scene& scene, const LightSet& lights) {
  const ShownReport& report = facts.report;
  std::vector<Fact> words{{"pixel", fmt::format("{} eye, {}, {}", facts.side == Side::Left ? "left" : "right",
                                                facts.pixel.x, facts.pixel.y)}};
  if (facts.surface.distance_m <= 0) {
    words.push_back({"depth", "no surface"});
    return words;
  }
  const glm::vec3& normal = facts.surface.normal;
  words.push_back({"depth", fmt::format("{:.3f} m", facts.surface.distance_m)});
  words.push_back({"normal", fmt::format("{:.2f}, {:.2f}, {:.2f}", normal.x, normal.y, normal.z)});
  if (const auto& instance = facts.surface.instance)
    words.push_back({"instance", fmt::format("{}, detail level {}", instance->index, instance->level)});
  const std::uint8_t source = report.sources.at(0);
  const bool is_known = source != kSourceUnknown,
             has_mask = is_mask(source) && (facts.masks > 0 || is_face(source));
  words.push_back(
      {"source", is_known && source != kSourceRays && !has_mask ? "shadow maps" : source_of(source)});
  if (has_mask) {
    words.push_back({"age", fmt::format("{:.0f} ms", ms_of(facts.ages.at(mask_of(source))))});
    const auto [x, y] = report.positions.at(0);
    words.push_back({"found at", fmt::format("{:.2f}, {:.2f} of that mask", x, y)});
  }
  words.push_back({"lit at most by", fmt::format("{} of {} lights, a shadow ray each", report.rays.at(0),
                                                 report.mask.lights())});
  for (std::uint32_t i = 0; i < report.mask.lights(); ++i) {
    const std::string& name = scene.lights[i].name;
    words.push_back({name.empty() ? fmt::format("light {}", i) : name,
                     lights.lights[i].on ? visibility_of(report, i) : "off"});
  }
  return words;
}

}  // namespace farshade
