#include "vr_client/draw/mask_edges.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// Plane `plane` of a mask as words.
template <class Word>
std::span<const Word> words_of(const EyeMask& mask, std::uint32_t plane) {
  const std::size_t count = mask.size().pixels();
  return {reinterpret_cast<const Word*>(mask.bytes().data()) + plane * count, count};
}

/// Sets `edge` to 1 at pixels whose 3x3 neighbourhood in `words` is not of one value.
template <class Word>
void mark_edges(std::span<const Word> words, Extent size, std::vector<std::uint8_t>& edge) {
  const std::size_t w = size.width, h = size.height;
  std::vector<Word> any(w * h), all(w * h);  // of a pixel and its neighbours left and right
  for (std::size_t y = 0; y < h; ++y) {
    const Word* const row = words.data() + y * w;
    Word *const row_any = any.data() + y * w, *const row_all = all.data() + y * w;
    for (std::size_t x = 1; x + 1 < w; ++x) {
      row_any[x] = static_cast<Word>(row[x - 1] | row[x] | row[x + 1]);
      row_all[x] = static_cast<Word>(row[x - 1] & row[x] & row[x + 1]);
    }
    for (const std::size_t x : {std::size_t{0}, w - 1}) {
      const Word left = row[x == 0 ? 0 : x - 1], right = row[x + 1 < w ? x + 1 : x];
      row_any[x] = static_cast<Word>(left | row[x] | right);
      row_all[x] = static_cast<Word>(left & row[x] & right);
    }
  }
  for (std::size_t y = 0; y < h; ++y) {
    const std::size_t above = (y == 0 ? 0 : y - 1) * w, here = y * w, below = (y + 1 < h ? y + 1 : y) * w;
    for (std::size_t x = 0; x < w; ++x) {
      const Word lit = static_cast<Word>(any[above + x] | any[here + x] | any[below + x]);
      const Word kept = static_cast<Word>(all[above + x] & all[here + x] & all[below + x]);
      edge[here + x] = static_cast<std::uint8_t>(edge[here + x] | (lit != kept));
    }
  }
}

template <class From, class To>
void copy(const EyeMask& mask, std::span<std::byte> out) {
  const MaskLayout from = mask.layout(), to = with_edge_bit(from);
  const std::size_t pixels = mask.size().pixels();
  std::vector<std::uint8_t> edge(pixels, 0);
  for (std::uint32_t plane = 0; plane < from.planes(); ++plane)
    mark_edges(words_of<From>(mask, plane), mask.size(), edge);
  To* const words = reinterpret_cast<To*>(out.data());
  for (std::uint32_t plane = 0; plane < to.planes(); ++plane) {
    To* const target = words + plane * pixels;
    const unsigned bit = from.lights % 32;
    const bool has_edges = plane == from.lights / 32;
    if (plane >= from.planes()) {
      for (std::size_t i = 0; i < pixels; ++i) target[i] = edge[i];
      continue;
    }
    const std::span<const From> source = words_of<From>(mask, plane);
    for (std::size_t i = 0; i < pixels; ++i)
      target[i] = static_cast<To>(source[i] | (has_edges ? static_cast<To>(edge[i]) << bit : 0));
  }
}

}  // namespace

void copy_with_edges(const EyeMask& mask, std::span<std::byte> out) {
  check_eq(out.size(), mask_bytes(mask.size(), with_edge_bit(mask.layout())), "bytes of a device mask");
  if (mask.size().pixels() == 0) return;
  const std::uint32_t from = mask.layout().word_bytes(), to = with_edge_bit(mask.layout()).word_bytes();
  if (from == 1 && to == 1) return copy<std::uint8_t, std::uint8_t>(mask, out);
  if (from == 1) return copy<std::uint8_t, std::uint16_t>(mask, out);
  if (from == 2 && to == 2) return copy<std::uint16_t, std::uint16_t>(mask, out);
  if (from == 2) return copy<std::uint16_t, std::uint32_t>(mask, out);
  copy<std::uint32_t, std::uint32_t>(mask, out);
}

}  // namespace farshade
