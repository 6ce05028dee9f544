#include "stereo/reproject/mask_edges.h"

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

/// Sets `differs` at (x, y) to 1 if the pixels x and x + 1 of rows y and y + 1 do not all have the same word.
template <class Word>
void mark_corners(std::span<const Word> words, Extent size, std::vector<std::uint8_t>& differs) {
  const std::size_t w = size.width;
  for (std::size_t y = 0; y + 1 < size.height; ++y) {
    const Word *const above = words.data() + y * w, *const below = above + w;
    std::uint8_t* const row = differs.data() + y * w;
    for (std::size_t x = 0; x + 1 < w; ++x)
      row[x] = static_cast<std::uint8_t>(row[x] | (above[x] != above[x + 1]) | (above[x] != below[x]) |
                                         (above[x] != below[x + 1]));
  }
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
void copy(const EyeMask& mask, WriteOnly<std::byte> out) {
  const MaskLayout from = mask.layout(), to = with_edge_bits(from);
  const std::size_t pixels = mask.size().pixels();
  std::vector<std::uint8_t> differs(pixels, 0);
  for (std::uint32_t plane = 0; plane < from.planes(); ++plane)
    mark_corners(words_of<From>(mask, plane), mask.size(), differs);
  const std::vector<std::uint8_t> edges = edges_of(differs, mask.size());
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

}  // namespace

void copy_with_edges(const EyeMask& mask, WriteOnly<std::byte> out) {
  check_eq(out.size(), mask_bytes(mask.size(), with_edge_bits(mask.layout())), "bytes of a device mask");
  if (mask.size().pixels() == 0) return;
  const std::uint32_t from = mask.layout().word_bytes(), to = with_edge_bits(mask.layout()).word_bytes();
  if (from == 1 && to == 1) return copy<std::uint8_t, std::uint8_t>(mask, out);
  if (from == 1) return copy<std::uint8_t, std::uint16_t>(mask, out);
  if (from == 2 && to == 2) return copy<std::uint16_t, std::uint16_t>(mask, out);
  if (from == 2) return copy<std::uint16_t, std::uint32_t>(mask, out);
  copy<std::uint32_t, std::uint32_t>(mask, out);
}

}  // namespace farshade
