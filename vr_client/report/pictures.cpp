#include "vr_client/report/pictures.h"

#include <fmt/format.h>

#include <algorithm>

#include "stereo/image/codec.h"
#include "stereo/image/difference.h"

namespace farshade {
namespace {

/// Arranges pictures of one size in rows, two pixels apart.
Image<Rgb8> sheet(const std::vector<std::vector<Image<Rgb8>>>& rows) {
  constexpr std::uint32_t gap = 2;
  const Extent cell = rows[0][0].size;
  const auto columns = static_cast<std::uint32_t>(rows[0].size()),
             lines = static_cast<std::uint32_t>(rows.size());
  Image<Rgb8> result({columns * (cell.width + gap) - gap, lines * (cell.height + gap) - gap}, Rgb8(255));
  for (std::uint32_t line = 0; line < lines; ++line)
    for (std::uint32_t column = 0; column < columns; ++column)
      for (std::uint32_t y = 0; y < cell.height; ++y)
        std::copy_n(&rows[line][column].at(0, y), cell.width,
                    &result.at(column * (cell.width + gap), line * (cell.height + gap) + y));
  return result;
}

}  // namespace

Expected<void> write_shown(const std::filesystem::path& folder, FrameId frame,
                           const PerEye<Image<Rgb8>>& shown) {
  for (const Side side : kSides)
    if (auto done = write_png(folder / fmt::format("frame_{:04}_{}.png", frame.value, name_of(side)),
                              shown[index_of(side)]);
        !done)
      return done;
  return {};
}

Expected<void> write_measured(const std::filesystem::path& folder, const MeasuredFrame& frame) {
  std::vector<std::vector<Image<Rgb8>>> rows;
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    const Extent size = frame.shown[eye].size;
    rows.push_back(
        {frame.shown[eye], frame.reference[eye], difference_x8(frame.shown[eye], frame.reference[eye])});
    if (!frame.report[eye].sources.empty())
      rows.back().push_back(source_picture(frame.report[eye], frame.ages, size));
    constexpr std::array names{"shown", "reference", "difference_x8", "source"};
    for (std::size_t i = 0; i < rows.back().size(); ++i) {
      const std::string name =
          fmt::format("worst_{:04}_{}_{}.png", frame.frame.value, name_of(side), names[i]);
      if (auto done = write_png(folder / name, rows.back()[i]); !done) return done;
    }
  }
  return write_png(folder / "worst.png", sheet(rows));
}

}  // namespace farshade
