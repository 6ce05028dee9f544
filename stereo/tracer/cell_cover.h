/// Cells of a light's directions: which cells may a triangle touch, and at which least depth from the light?
///
/// This is conservative rasterisation as J. Hasselgren, T. Akenine-Moeller and L. Ohlsson define it
/// ("Conservative Rasterization", GPU Gems 2, chapter 42). The triangle is clipped to each face (I. E.
/// Sutherland and G. W. Hodgman, "Reentrant Polygon Clipping", 1974), and in each row of cells it covers the
/// extent of the part of it that lies in that row.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "stereo/tracer/anchor_space.h"

namespace farshade {

/// Maps directions from a light to numbered cells: `side` x `side` cells on each face, row by row.
struct CellFrame {
  /// Faces and rows are widened by this many cells. Float arithmetic may count a point to the neighbouring
  /// cell, since its cell coordinates are wrong by up to 1e-5 cells.
  static constexpr double kMargin = 1e-3;

  /// True for point and spot lights: six faces of a cube around `origin`. Face 2a looks along axis a and face
  /// 2a + 1 against it; x and y are the other two axes in order; cell coordinates are (x / depth + 1) * side
  /// / 2. False for directional lights: one face; `rows` * (p - origin) gives x and y in cells from the
  /// face's centre, and the depth in metres.
  bool cube = true;
  int side = 0;
  Point<Anchor> origin;
  std::array<glm::dvec3, 3> rows{};
  double rounding = 0;  ///< metres: the traversal may treat a triangle as displaced by up to this much

  [[nodiscard]] int faces() const { return cube ? 6 : 1; }
  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(faces()) * static_cast<std::size_t>(side * side);
  }
};

struct CellTouch {
  std::uint32_t cell;
  float depth;  ///< metres: no point of the triangle in this cell is nearer to the light
};

/// Appends to `touched`, once each, every cell through which the light may see any part of the triangle.
void cover(const CellFrame& frame, const std::array<Point<Anchor>, 3>& triangle,
           std::vector<CellTouch>& touched);

}  // namespace farshade
