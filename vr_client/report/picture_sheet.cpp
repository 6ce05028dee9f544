#include "vr_client/report/picture_sheet.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace farshade {
namespace {

constexpr std::uint32_t kGap = 2;  ///< pixels between cells
constexpr int kMargin = 2;         ///< pixels around a label

/// Dear ImGui's own bitmap font, which needs no device.
class LabelFont {
 public:
  LabelFont() : font_(atlas_.AddFontDefault()) {
    int height = 0;
    atlas_.GetTexDataAsAlpha8(&texels_, &width_, &height);
    height_ = height;
  }

  [[nodiscard]] std::uint32_t line_height() const {
    return static_cast<std::uint32_t>(std::ceil(font_->FontSize)) + 2 * kMargin;
  }

  /// Writes black text into the strip of `width` pixels whose top left corner is (left, top).
  void write(const std::string& text, std::uint32_t left, std::uint32_t top, std::uint32_t width,
             Image<Rgb8>& image) const {
    float pen = kMargin;
    for (const char letter : text) {
      const ImFontGlyph* const glyph = font_->FindGlyph(static_cast<ImWchar>(letter));
      if (pen + glyph->AdvanceX > static_cast<float>(width)) return;
      const int u = texel(glyph->U0, width_), v = texel(glyph->V0, height_);
      for (int y = 0; y < texel(glyph->V1, height_) - v; ++y)
        for (int x = 0; x < texel(glyph->U1, width_) - u; ++x) {
          const unsigned alpha = texels_[(v + y) * width_ + u + x];
          const auto at = [](std::uint32_t from, float along) {
            return from + static_cast<std::uint32_t>(along);
          };
          Rgb8& pixel = image.at(at(left, pen + glyph->X0 + static_cast<float>(x)),
                                 at(top, kMargin + glyph->Y0 + static_cast<float>(y)));
          const auto ink = static_cast<std::uint8_t>(255 - alpha);
          pixel = {std::min(pixel.r, ink), std::min(pixel.g, ink), std::min(pixel.b, ink)};
        }
      pen += glyph->AdvanceX;
    }
  }

 private:
  static int texel(float part, int of) {
    return static_cast<int>(std::lround(part * static_cast<float>(of)));
  }

  ImFontAtlas atlas_;
  ImFont* font_;
  unsigned char* texels_ = nullptr;
  int width_ = 0, height_ = 0;
};

}  // namespace

Image<Rgb8> picture_sheet(const std::vector<std::vector<LabelledPicture>>& rows) {
  const LabelFont font;
  const Extent picture = rows[0][0].picture.size;
  const Extent cell{picture.width + kGap, picture.height + font.line_height() + kGap};
  const auto columns = static_cast<std::uint32_t>(rows[0].size()),
             lines = static_cast<std::uint32_t>(rows.size());
  Image<Rgb8> result({columns * cell.width - kGap, lines * cell.height - kGap}, Rgb8(255));
  for (std::uint32_t line = 0; line < lines; ++line)
    for (std::uint32_t column = 0; column < columns; ++column) {
      const LabelledPicture& one = rows[line][column];
      const std::uint32_t left = column * cell.width, top = line * cell.height;
      font.write(one.label, left, top, picture.width, result);
      for (std::uint32_t y = 0; y < picture.height; ++y)
        std::copy_n(&one.picture.at(0, y), picture.width, &result.at(left, top + font.line_height() + y));
    }
  return result;
}

}  // namespace farshade
