#include "stereo/edge_rays/light_buffer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <future>
#include <limits>
#include <thread>

#include "stereo/base/check.h"

namespace farshade {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A list with more triangles is divided, but no texel more than this many times.
constexpr std::size_t kMostTriangles = 8;
constexpr int kMostDivisions = FARSHADE_LIGHT_BUFFER_DIVISIONS;

constexpr std::ptrdiff_t kTexels = FARSHADE_LIGHT_BUFFER_SIDE * FARSHADE_LIGHT_BUFFER_SIDE;  ///< of a layer
constexpr std::size_t kParts = FARSHADE_LIGHT_BUFFER_PARTS * FARSHADE_LIGHT_BUFFER_PARTS;

/// Texels are found as if they were larger by this share on each side, because shaders round the place in a
/// layer.
constexpr double kMargin = 1.0 / 256;

/// Shaders also round points, lights and corners. A texel's margin contains that error, as a share of the
/// scene's size.
constexpr double kRounding = 8 * 0x1p-24;

/// A step of depths is larger than kRounding of the scene.
constexpr int kMostDepthBits = 16;

/// A light counts as in a triangle's plane if it is nearer to it than this share of the distance of its
/// corners.
constexpr double kInPlane = 1e-9;

/// Tells the threads that make a buffer when to give up.
class Limit {
 public:
  Limit(std::size_t most_words, const std::stop_token& stop) : most_(most_words), stop_(stop) {}

  /// Of the buffer.
  void add(std::size_t words) { words_ += words; }
  /// `count`: all entries in the lists of a square of texels.
  void check_lists(std::size_t count) {
    if (count > most_) add(most_ + 1);
  }
  [[nodiscard]] bool is_over() const { return words_ > most_ || stop_.stop_requested(); }

 private:
  std::size_t most_;
  const std::stop_token& stop_;
  std::atomic<std::size_t> words_ = 0;
};

/// A convex polygon. Four clips make at most 7 corners of 3; if rounding makes it concave, at most 13.
struct Polygon {
  std::array<glm::dvec3, 13> corners;
  std::size_t count = 0;

  void add(const glm::dvec3& corner) { corners[count++] = corner; }
};

/// The part of `polygon` where `inside`, which is linear, is at least 0.
template <class Inside>
Polygon clipped(const Polygon& polygon, const Inside& inside) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const glm::dvec3 &a = polygon.corners[i], &b = polygon.corners[(i + 1) % polygon.count];
    const double at_a = inside(a), at_b = inside(b);
    if (at_a >= 0) result.add(a);
    if ((at_a >= 0) != (at_b >= 0)) result.add(a + (b - a) * (at_a / (at_a - at_b)));
  }
  return result;
}

/// A triangle's part in a layer.
struct Footprint {
  std::uint32_t triangle = 0;
  Polygon
      polygon;  ///< xy in shares of the layer's side, z the distance from the light along the layer's axis
  double nearest = kInfinity, farthest = -kInfinity;  ///< distances
  glm::dvec2 margin{0.0};                             ///< for rounding, in shares of the layer's side
  bool has_holes = false;
};

/// Whether the light lies in the triangle's plane, within rounding. Such a triangle hides nothing, and its
/// projection is rounding errors.
bool is_edge_on(const std::array<glm::dvec3, 3>& corners) {
  const auto& [a, b, c] = corners;
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double size = std::max({glm::length(a), glm::length(b), glm::length(c)});
  return std::abs(glm::dot(normal, a)) <= kInPlane * size * glm::length(normal);
}

/// `corners` are relative to the light. Empty if the triangle hides nothing in the layer.
Footprint footprint_of(const MapView& view, std::uint32_t triangle,
                       const std::array<glm::dvec3, 3>& corners) {
  const bool parallel = view.kind == FARSHADE_MAP_PARALLEL;
  Footprint result{.triangle = triangle, .polygon = {}};
  if (!parallel && is_edge_on(corners)) return result;
  Polygon& polygon = result.polygon;
  for (const glm::dvec3& p : corners)
    polygon.add({glm::dot(p, view.right), glm::dot(p, view.up), glm::dot(p, view.ahead)});
  const glm::dvec2 reach = 0.5 * view.side_px / view.texels;
  for (const double sign : {-1.0, 1.0})
    for (int axis = 0; axis < 2; ++axis)
      polygon = clipped(polygon, [&](const glm::dvec3& p) {
        return reach[axis] * (parallel ? 1.0 : p.z) + sign * p[axis];
      });
  for (std::size_t i = 0; i < polygon.count; ++i) {
    glm::dvec3& p = polygon.corners[i];
    const double depth = parallel ? 1.0 : p.z;
    p.x = 0.5 + 0.5 * p.x / (depth * reach.x);
    p.y = 0.5 - 0.5 * p.y / (depth * reach.y);
    result.nearest = std::min(result.nearest, p.z);
    result.farthest = std::max(result.farthest, p.z);
  }
  return result;
}

struct Range {
  double low = kInfinity, high = -kInfinity;
  void add(double x) { low = std::min(low, x), high = std::max(high, x); }
};

using List = std::vector<const Footprint*>;

/// A square of texels, and the list of each.
struct Square {
  double x = 0, y = 0, step = 1;  ///< corner and side of a texel, in shares of the layer's side
  std::uint32_t side = 1;         ///< texels
  std::vector<List> lists{};      ///< by row and column
};

/// A footprint's margin around a texel, in texels.
glm::dvec2 margin_of(const Square& square, const Footprint& footprint) {
  return kMargin + footprint.margin / square.step;
}

/// Calls `visit(texel, covers)` for each texel of a row that a footprint touches; `covers`: all of it.
template <class Visit>
void visit_row(const Square& square, std::uint32_t row, const Footprint& footprint, const Visit& visit) {
  const Polygon& polygon = footprint.polygon;
  const glm::dvec2 margin = margin_of(square, footprint);
  const auto local = [&](const glm::dvec3& p) {
    return glm::dvec2((p.x - square.x) / square.step, (p.y - square.y) / square.step);
  };
  const double top = row - margin.y, bottom = row + 1 + margin.y;
  Range touched, at_top, at_bottom;
  glm::dvec2 a = local(polygon.corners[polygon.count - 1]);
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const glm::dvec2 b = local(polygon.corners[i]);
    if (b.y >= top && b.y <= bottom) touched.add(b.x);
    for (const double y : {top, bottom}) {
      if ((a.y < y) == (b.y < y)) continue;
      const double x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
      touched.add(x);
      (y == top ? at_top : at_bottom).add(x);
    }
    a = b;
  }
  const double last = square.side - 1.0, low = std::floor(touched.low - margin.x),
               high = std::floor(touched.high + margin.x);
  if (low > last || high < 0 || low > high) return;
  const auto to = static_cast<std::uint32_t>(std::min(high, last));
  for (auto column = static_cast<std::uint32_t>(std::max(low, 0.0)); column <= to; ++column)
    visit(row * square.side + column, column - margin.x >= std::max(at_top.low, at_bottom.low) &&
                                          column + 1 + margin.x <= std::min(at_top.high, at_bottom.high));
}

/// A distance that is surely larger, also if it is negative, as in a parallel projection.
double beyond(double distance) {
  return distance + 1e-6 * std::abs(distance);
}

/// Fills the lists of `square` with those of `footprints`, nearest first, without those that a texel hides.
/// The lists have no meaning if the limit is over afterwards.
void fill(Square& square, const List& footprints, Limit& limit) {
  square.lists.assign(std::size_t{square.side} * square.side, {});
  std::vector<double> hidden(square.lists.size(), kInfinity);  // beyond this distance
  const double last = square.side - 1.0;
  std::size_t entries = 0;
  for (const Footprint* footprint : footprints) {
    limit.check_lists(entries);
    if (limit.is_over()) return;
    Range rows;
    for (std::size_t i = 0; i < footprint->polygon.count; ++i)
      rows.add((footprint->polygon.corners[i].y - square.y) / square.step);
    const double margin = margin_of(square, *footprint).y, low = std::max(std::floor(rows.low - margin), 0.0),
                 high = std::min(std::floor(rows.high + margin), last);
    for (double row = low; row <= high; ++row)
      visit_row(square, static_cast<std::uint32_t>(row), *footprint, [&](std::uint32_t texel, bool covers) {
        if (footprint->nearest > hidden[texel]) return;
        square.lists[texel].push_back(footprint);
        ++entries;
        if (covers && !footprint->has_holes)
          hidden[texel] = std::min(hidden[texel], beyond(footprint->farthest));
      });
  }
  for (std::size_t texel = 0; texel < hidden.size(); ++texel)
    std::erase_if(square.lists[texel], [&](const Footprint* f) { return f->nearest > hidden[texel]; });
}

/// The word of a triangle in a list.
std::uint32_t word_of(const Footprint& footprint, const ListDepths& depths) {
  const double steps = depths.step_m > 0 ? (footprint.nearest - depths.first_m) / depths.step_m : 0;
  return footprint.triangle | static_cast<std::uint32_t>(steps) << depths.number_bits;
}

/// Appends the parts and lists of the texels of `square`, whose words begin at `first`, until the limit is
/// over.
void write(const Square& square, std::size_t first, int divisions, const ListDepths& depths, Limit& limit,
           LightBuffer& into) {
  for (std::size_t texel = 0; texel < square.lists.size() && !limit.is_over(); ++texel) {
    const List& list = square.lists[texel];
    if (list.empty()) continue;
    const auto here = static_cast<std::uint32_t>(into.size());
    if (list.size() > kMostTriangles && divisions < kMostDivisions) {
      Square parts{.side = FARSHADE_LIGHT_BUFFER_PARTS};
      parts.step = square.step / parts.side;
      parts.x = square.x + static_cast<double>(texel % square.side) * square.step;
      parts.y = square.y + static_cast<double>(texel / square.side) * square.step;
      fill(parts, list, limit);
      std::size_t all = 0;
      for (const List& part : parts.lists) all += part.size();
      if (all < list.size() * parts.lists.size() * 3 / 4) {
        into[first + texel] = FARSHADE_DIVIDED | here;
        into.resize(into.size() + parts.lists.size());
        limit.add(parts.lists.size());
        write(parts, here, divisions + 1, depths, limit, into);
        continue;
      }
    }
    into[first + texel] = here;
    for (const Footprint* footprint : list) into.push_back(word_of(*footprint, depths));
    into.back() |= FARSHADE_LAST;
    limit.add(list.size());
  }
}

/// The footprints of all triangles in a layer, or of some once the limit is over.
std::vector<Footprint> footprints_in(const MapView& view, const CasterTriangles& casters,
                                     const Limit& limit) {
  std::vector<Footprint> footprints;
  const glm::dvec3 shift = casters.origin.v - view.origin.v;
  double size = glm::length(shift);
  for (const std::array<glm::vec3, 3>& corners : casters.corners)
    for (const glm::vec3& corner : corners) size = std::max(size, double{glm::length(corner)});
  for (std::uint32_t t = 0; t < casters.corners.size() && !limit.is_over(); ++t) {
    std::array<glm::dvec3, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) corners[c] = glm::dvec3(casters.corners[t][c]) + shift;
    Footprint footprint = footprint_of(view, t, corners);
    if (footprint.polygon.count < 3) continue;
    const double depth = view.kind == FARSHADE_MAP_PARALLEL ? 1.0 : footprint.nearest;
    footprint.margin = kRounding * size / depth * view.texels / static_cast<double>(view.side_px);
    footprint.has_holes = casters.has_holes[t];
    footprints.push_back(footprint);
  }
  return footprints;
}

/// The words of one layer; indices count from its first word. They have no meaning once the limit is over.
LightBuffer make_layer(const MapView& view, const CasterTriangles& casters, Limit& limit) {
  const std::vector<Footprint> footprints = footprints_in(view, casters, limit);
  List all;
  for (const Footprint& footprint : footprints) all.push_back(&footprint);
  std::ranges::sort(all, {}, [](const Footprint* f) { return std::pair(f->nearest, f->triangle); });
  Square square{.step = 1.0 / FARSHADE_LIGHT_BUFFER_SIDE, .side = FARSHADE_LIGHT_BUFFER_SIDE};
  fill(square, all, limit);
  LightBuffer result(square.lists.size());
  limit.add(result.size());
  write(square, 0, 0, list_depths(view, casters), limit, result);
  return result;
}

/// Adds `shift` to the indices of `count` texels from `first` on, and of their parts.
void move_indices(std::size_t first, std::size_t count, std::uint32_t shift, LightBuffer& buffer) {
  for (std::size_t texel = first; texel < first + count; ++texel) {
    if (buffer[texel] == 0) continue;
    if ((buffer[texel] & FARSHADE_DIVIDED) != 0)
      move_indices(buffer[texel] & ~FARSHADE_DIVIDED, kParts, shift, buffer);
    buffer[texel] += shift;
  }
}

std::uint32_t layers_of(const MapView& view) {
  return view.kind == FARSHADE_MAP_CUBE ? 6 : 1;
}

/// Checks the words of a buffer, and counts those that belong to a texel or a list.
class Checker {
 public:
  Checker(std::span<const std::uint32_t> buffer, std::size_t triangles, const ListDepths& depths)
      : buffer_(buffer), triangles_(triangles), numbers_((1u << depths.number_bits) - 1) {}

  bool checks_texels(std::size_t first, std::size_t count, int divisions) {
    if (first > buffer_.size() || count > buffer_.size() - first || !uses(count)) return false;
    return std::ranges::all_of(buffer_.subspan(first, count), [&](std::uint32_t word) {
      if ((word & FARSHADE_DIVIDED) == 0) return word == 0 || checks_list(word);
      return divisions < kMostDivisions && checks_texels(word & ~FARSHADE_DIVIDED, kParts, divisions + 1);
    });
  }
  [[nodiscard]] bool used_all() const { return used_ == buffer_.size(); }

 private:
  /// Words that are used twice are more than there are.
  bool uses(std::size_t count) { return (used_ += count) <= buffer_.size(); }
  bool checks_list(std::size_t at) {
    for (; at < buffer_.size() && uses(1); ++at) {
      if ((buffer_[at] & numbers_) >= triangles_) return false;
      if ((buffer_[at] & FARSHADE_LAST) != 0) return true;
    }
    return false;
  }

  std::span<const std::uint32_t> buffer_;
  std::size_t triangles_, used_ = 0;
  std::uint32_t numbers_;  ///< the bits of a triangle's number
};

/// Calls `make` for each layer, from as many threads as there are cores.
template <class Make>
void for_layers(std::uint32_t layers, const Make& make) {
  std::atomic<std::uint32_t> next = 0;
  const auto make_some = [&] {
    for (std::uint32_t layer = next++; layer < layers; layer = next++) make(layer);
  };
  std::vector<std::future<void>> others;
  for (std::uint32_t thread = 1; thread < std::min(layers, std::thread::hardware_concurrency()); ++thread)
    others.push_back(std::async(std::launch::async, make_some));
  make_some();
  for (std::future<void>& other : others) other.get();
}

}  // namespace

ListDepths list_depths(const MapView& view, const CasterTriangles& casters) {
  double farthest = 0;
  for (const std::array<glm::vec3, 3>& corners : casters.corners)
    for (const glm::vec3& corner : corners) farthest = std::max(farthest, double{glm::length(corner)});
  farthest += glm::length(casters.origin.v - view.origin.v);
  const int number_bits = std::min(static_cast<int>(std::bit_width(casters.corners.size())), 31);
  const int bits = std::min(31 - number_bits, kMostDepthBits);
  const double steps = std::ldexp(1.0, bits) - 1;
  const double first = view.kind == FARSHADE_MAP_PARALLEL ? -farthest : 0;
  return {static_cast<std::uint32_t>(number_bits), first, steps > 0 ? (farthest - first) / steps : 0};
}

std::optional<LightBuffer> make_light_buffer(const MapView& view, const CasterTriangles& casters,
                                             std::size_t most_words, const std::stop_token& stop) {
  const std::uint32_t layers = layers_of(view);
  std::vector<LightBuffer> made(layers);
  Limit limit(most_words, stop);
  for_layers(layers, [&](std::uint32_t layer) {
    made[layer] = make_layer(view.kind == FARSHADE_MAP_CUBE ? face_view(view, layer) : view, casters, limit);
  });
  if (limit.is_over()) return std::nullopt;
  LightBuffer result(layers * kTexels);
  for (std::uint32_t layer = 0; layer < layers; ++layer) {
    LightBuffer& of_layer = made[layer];
    move_indices(0, kTexels, narrow<std::uint32_t>(result.size() - kTexels), of_layer);
    const auto lists = of_layer.begin() + kTexels;
    std::copy(of_layer.begin(), lists, result.begin() + layer * kTexels);
    result.insert(result.end(), lists, of_layer.end());
  }
  return result;
}

bool is_light_buffer(std::span<const std::uint32_t> buffer, const MapView& view,
                     const CasterTriangles& casters) {
  Checker checker(buffer, casters.corners.size(), list_depths(view, casters));
  return checker.checks_texels(0, layers_of(view) * kTexels, 0) && checker.used_all();
}

}  // namespace farshade
