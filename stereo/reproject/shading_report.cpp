#include <algorithm>
#include <bit>

#include "stereo/reproject/shading.h"

namespace farshade {
namespace {

/// One pixel's record in the report (shade_data.h).
struct Record {
  std::span<const std::uint32_t> words;
  std::uint32_t lights;

  [[nodiscard]] std::uint8_t source() const {
    return static_cast<std::uint8_t>(words[FARSHADE_REPORT_SOURCE]);
  }
  [[nodiscard]] std::uint16_t rays() const {
    return static_cast<std::uint16_t>(words[FARSHADE_REPORT_SOURCE] >> 16);
  }
  [[nodiscard]] std::array<float, 2> position() const {
    return {std::bit_cast<float>(words[FARSHADE_REPORT_X]), std::bit_cast<float>(words[FARSHADE_REPORT_Y])};
  }
  [[nodiscard]] std::uint8_t visibility(std::size_t light) const {
    return static_cast<std::uint8_t>(words[FARSHADE_REPORT_VISIBILITY + light / 4] >> (light % 4 * 8));
  }
  [[nodiscard]] std::uint32_t unknown(std::size_t plane) const {
    return words[FARSHADE_REPORT_UNKNOWN(lights) + plane];
  }
  [[nodiscard]] std::uint32_t stale(std::size_t plane) const {
    return words[FARSHADE_REPORT_STALE(lights) + plane];
  }
};

}  // namespace

ShownReport ShadingPass::report(Side side, const TileRect& part) const {
  check(part.x0 < part.x1 && part.x1 <= size_.width && part.y0 < part.y1 && part.y1 <= size_.height,
        "the part is in the picture");
  const Extent size{part.x1 - part.x0, part.y1 - part.y0};
  const std::uint32_t lights = plan_.mask.lights, planes = FARSHADE_PLANES(lights);
  const std::size_t pixels = size.pixels(), words = FARSHADE_REPORT_WORDS(lights);
  ShownReport result{.mask = EyeMask(size, plan_.mask),
                     .sources = std::vector<std::uint8_t>(pixels),
                     .positions = std::vector<std::array<float, 2>>(pixels),
                     .visibility = std::vector<std::uint8_t>(pixels * lights),
                     .unknown = std::vector<std::uint32_t>(pixels * planes),
                     .stale = std::vector<std::uint32_t>(pixels * planes),
                     .rays = std::vector<std::uint16_t>(pixels)};
  const auto all = report_buffer_.as<std::uint32_t>().subspan(index_of(side) * size_.pixels() * words);
  for (std::size_t at = 0; at < pixels; ++at) {
    const auto x = static_cast<std::uint32_t>(at % size.width),
               y = static_cast<std::uint32_t>(at / size.width);
    const std::size_t in_picture = std::size_t{part.y0 + y} * size_.width + part.x0 + x;
    const Record record{all.subspan(in_picture * words, words), lights};
    result.sources[at] = record.source();
    result.rays[at] = record.rays();
    result.positions[at] = record.position();
    for (std::size_t i = 0; i < lights; ++i)
      result.visibility[at * lights + i] = off_[i] ? std::uint8_t{0} : record.visibility(i);
    for (std::uint32_t plane = 0; plane < planes; ++plane) {
      std::uint32_t bits = 0, on = 0;
      for (std::size_t i = std::size_t{plane} * 32, end = std::min<std::size_t>(lights, i + 32); i < end;
           ++i) {
        on |= std::uint32_t{!off_[i]} << i % 32;
        bits |= std::uint32_t{result.visibility[at * lights + i] >= 128} << i % 32;
      }
      result.mask.set_word(x, y, plane, bits);
      result.unknown[at * planes + plane] = record.unknown(plane) & on;
      result.stale[at * planes + plane] = record.stale(plane) & on;
    }
  }
  return result;
}

}  // namespace farshade
