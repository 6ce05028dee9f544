#include "stereo/reproject/mask_edges.h"

#include <algorithm>
#include <vector>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// The words of one plane.
template <class Word>
std::span<const Word> words_of(const EyeMask& mask, std::uint32_t plane) {
  const std::size_t count = mask.size().pixels();
  return {reinterpret_cast<const Word*>(mask.bytes().data()) + plane * count, count};
}

/// The lights that have an edge in each cell of a plane: those in which its four pixels differ.
template <class Word>
std::vector<Word> mixed_cells(std::span<const Word> words, Extent size) {
  const std::size_t w = size.width;
  std::vector<Word> cells(words.size());
  for (std::size_t y = 0; y + 1 < size.height; ++y) {
    const Word *const above = words.data() + y * w, *const below = above + w;
    Word* const row = cells.data() + y * w;
    for (std::size_t x = 0; x + 1 < w; ++x)
      row[x] =
          static_cast<Word>((above[x] ^ above[x + 1]) | (above[x] ^ below[x]) | (above[x] ^ below[x + 1]));
  }
  return cells;
}

/// The pixels that belong to lines of one pixel's width: those that differ from both horizontal neighbours,
/// and those that differ from both vertical ones.
template <class Word>
struct ThinPixels {
  std::vector<Word> upright, level;
};

template <class Word>
ThinPixels<Word> thin_pixels(std::span<const Word> words, Extent size, Word lights) {
  const std::size_t w = size.width, h = size.height;
  ThinPixels<Word> thin{std::vector<Word>(words.size()), std::vector<Word>(words.size())};
  const auto between = [lights](Word a, Word pixel, Word b) {
    return static_cast<Word>((a ^ pixel) & (b ^ pixel) & lights);
  };
  for (std::size_t y = 0; y < h; ++y) {
    const Word* const row = words.data() + y * w;
    for (std::size_t x = 1; x + 1 < w; ++x) thin.upright[y * w + x] = between(row[x - 1], row[x], row[x + 1]);
    if (y == 0 || y + 1 == h) continue;
    const Word *const above = row - w, *const below = row + w;
    for (std::size_t x = 0; x < w; ++x) thin.level[y * w + x] = between(above[x], row[x], below[x]);
  }
  return thin;
}

/// A line goes on this far beyond a cell's own pixels. It was chosen by measurement (docs/edge-rays.md).
constexpr std::size_t kAlong_px = 2;

/// Adds the lights of lines that end near a cell, or pass it, to those of the cell.
template <class Word>
void add_lines(const ThinPixels<Word>& thin, Extent size, std::vector<Word>& cells) {
  const std::size_t w = size.width, h = size.height;
  std::vector<Word> level(w + 2 * kAlong_px);  // of the two rows of a cell, with a margin
  for (std::size_t y = 0; y + 1 < h; ++y) {
    Word* const row = cells.data() + y * w;
    for (std::size_t at = y - std::min(y, kAlong_px); at <= std::min(y + 1 + kAlong_px, h - 1); ++at) {
      const Word* const upright = thin.upright.data() + at * w;
      for (std::size_t x = 0; x + 1 < w; ++x)
        row[x] = static_cast<Word>(row[x] | upright[x] | upright[x + 1]);
    }
    const Word* const upper = thin.level.data() + y * w;
    for (std::size_t x = 0; x < w; ++x) level[kAlong_px + x] = static_cast<Word>(upper[x] | upper[w + x]);
    for (std::size_t along = 0; along < 2 * kAlong_px + 2; ++along)
      for (std::size_t x = 0; x + 1 < w; ++x) row[x] = static_cast<Word>(row[x] | level[x + along]);
  }
}

/// Of a mask, the cells of each plane.
template <class Word>
using Cells = std::vector<std::vector<Word>>;

template <class Word>
Cells<Word> cells_of(const EyeMask& mask, const LightBits& thin) {
  Cells<Word> cells;
  for (std::uint32_t plane = 0; plane < mask.layout().planes(); ++plane) {
    const std::span<const Word> words = words_of<Word>(mask, plane);
    cells.push_back(mixed_cells(words, mask.size()));
    if (thin[plane] != 0)
      add_lines(thin_pixels(words, mask.size(), static_cast<Word>(thin[plane])), mask.size(), cells.back());
  }
  return cells;
}

/// 1 for each cell with an edge in some light.
template <class Word>
std::vector<std::uint8_t> with_edge(const Cells<Word>& cells) {
  std::vector<std::uint8_t> edge(cells[0].size(), 0);
  for (const std::vector<Word>& plane : cells)
    for (std::size_t i = 0; i < edge.size(); ++i)
      edge[i] = static_cast<std::uint8_t>(edge[i] | (plane[i] != 0));
  return edge;
}

/// The four edge bits of each pixel.
std::vector<std::uint8_t> edges_of(const std::vector<std::uint8_t>& differs, Extent size) {
  const std::size_t w = size.width;
  std::vector<std::uint8_t> edges(differs.size());
  const std::vector<std::uint8_t> no_edges(w, 0);
  for (std::size_t y = 0; y < size.height; ++y) {
    const std::uint8_t *const lower = differs.data() + y * w, *const upper =
                                                                  y == 0 ? no_edges.data() : lower - w;
    std::uint8_t* const row = edges.data() + y * w;
    row[0] = static_cast<std::uint8_t>(upper[0] << 1 | lower[0] << 3);
    for (std::size_t x = 1; x < w; ++x)
      row[x] = static_cast<std::uint8_t>(upper[x - 1] | upper[x] << 1 | lower[x - 1] << 2 | lower[x] << 3);
  }
  return edges;
}

template <class From, class To>
void copy(const EyeMask& mask, const Cells<From>& cells, WriteOnly<std::byte> out) {
  const MaskLayout from = mask.layout(), to = with_edge_bits(from);
  const std::size_t pixels = mask.size().pixels();
  const std::vector<std::uint8_t> edges = edges_of(with_edge(cells), mask.size());
  const std::uint32_t edge_plane = first_edge_bit(from.lights) / 32, bit = first_edge_bit(from.lights) % 32;
  for (std::uint32_t plane = 0; plane < to.planes(); ++plane) {
    const WriteOnly<To> target = out.as<To>().part(plane * pixels, pixels);
    const From* const words = plane < from.planes() ? words_of<From>(mask, plane).data() : nullptr;
    const auto edge = [bits = edges.data(), bit](std::size_t i) {
      return static_cast<To>(static_cast<To>(bits[i]) << bit);
    };
    if (words == nullptr)
      target.generate(edge);  // the plane of the edges, without a light
    else if (plane == edge_plane)
      target.generate([=](std::size_t i) { return static_cast<To>(words[i] | edge(i)); });
    else
      target.generate([=](std::size_t i) { return static_cast<To>(words[i]); });
  }
}

/// Calls `copy.operator()<From, To>()` with the words of `mask` and of its copy on the device.
template <class Copy>
void for_words(const EyeMask& mask, const Copy& copy) {
  const std::uint32_t from = mask.layout().word_bytes(), to = with_edge_bits(mask.layout()).word_bytes();
  using std::uint16_t, std::uint32_t, std::uint8_t;
  if (mask.size().pixels() == 0) return;
  if (from == 1 && to == 1) return copy.template operator()<uint8_t, uint8_t>();
  if (from == 1) return copy.template operator()<uint8_t, uint16_t>();
  if (from == 2 && to == 2) return copy.template operator()<uint16_t, uint16_t>();
  if (from == 2) return copy.template operator()<uint16_t, uint32_t>();
  copy.template operator()<uint32_t, uint32_t>();
}

}  // namespace

void copy_with_edges(const EyeMask& mask, WriteOnly<std::byte> out) {
  check_eq(out.size(), mask_bytes(mask.size(), with_edge_bits(mask.layout())), "bytes of a device mask");
  for_words(mask, [&]<class From, class To>() { copy<From, To>(mask, cells_of<From>(mask, {}), out); });
}

void copy_with_cells(const EyeMask& mask, const LightBits& thin, WriteOnly<std::byte> out) {
  const std::size_t bits = mask_bytes(mask.size(), with_edge_bits(mask.layout())),
                    all = mask_and_cell_bytes(mask.size(), mask.layout());
  check_eq(out.size(), all, "bytes of a device mask with its cells");
  for_words(mask, [&]<class From, class To>() {
    const Cells<From> cells = cells_of<From>(mask, thin);
    copy<From, To>(mask, cells, out.part(0, bits));
    const WriteOnly<To> target = out.part(bits, all - bits).template as<To>();
    const std::size_t pixels = mask.size().pixels();
    for (std::size_t plane = 0; plane < cells.size(); ++plane)
      target.part(plane * pixels, pixels).generate([words = cells[plane].data()](std::size_t i) {
        return static_cast<To>(words[i]);
      });
  });
}

}  // namespace farshade
