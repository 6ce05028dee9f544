#include <bit>

#include "stereo/draw/shading.h"

namespace farshade {

ShownReport ShadingPass::report(Side side) const {
  const ReportLayout layout(plan_.mask);
  const std::size_t pixels = size_.pixels(), lights = plan_.mask.lights, planes = (lights + 31) / 32;
  ShownReport result{.mask = EyeMask(size_, plan_.mask),
                     .sources = std::vector<std::uint8_t>(pixels),
                     .positions = std::vector<std::array<float, 2>>(pixels),
                     .visibility = std::vector<std::uint8_t>(pixels * lights),
                     .unknown = std::vector<std::uint32_t>(pixels * planes),
                     .stale = std::vector<std::uint32_t>(pixels * planes),
                     .beside = std::vector<std::uint32_t>(pixels * planes),
                     .rays = std::vector<std::uint16_t>(pixels)};
  auto row = report_buffer_.as<const std::uint32_t>().subspan(index_of(side) * pixels * layout.words);
  for (std::size_t at = 0; at < pixels; ++at, row = row.subspan(layout.words)) {
    result.sources[at] = static_cast<std::uint8_t>(row[0]);
    result.rays[at] = static_cast<std::uint16_t>(row[0] >> 16);
    result.positions[at] = {std::bit_cast<float>(row[1]), std::bit_cast<float>(row[2])};
    for (std::size_t i = 0; i < lights; ++i)
      result.visibility[at * lights + i] =
          off_[i] ? std::uint8_t{0}
                  : static_cast<std::uint8_t>(row[layout.visibility + i / 4] >> (i % 4 * 8));
    for (std::uint32_t plane = 0; plane < planes; ++plane) {
      std::uint32_t bits = 0, on = 0;
      for (std::size_t i = plane * 32; i < std::min<std::size_t>(lights, plane * 32 + 32); ++i) {
        on |= std::uint32_t{!off_[i]} << i % 32;
        bits |= std::uint32_t{result.visibility[at * lights + i] >= 128} << i % 32;
      }
      result.mask.set_word(static_cast<std::uint32_t>(at % size_.width),
                           static_cast<std::uint32_t>(at / size_.width), plane, bits);
      result.unknown[at * planes + plane] = row[layout.unknown + plane] & on;
      result.stale[at * planes + plane] = row[layout.stale + plane] & on;
      result.beside[at * planes + plane] = row[layout.beside + plane] & on;
    }
  }
  return result;
}

}  // namespace farshade
