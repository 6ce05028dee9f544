/// Which cells of a light's directions may a triangle touch, and how near to the light does it come there?
///
/// Conservative rasterisation as J. Hasselgren, T. Akenine-Moeller and L. Ohlsson define it ("Conservative
/// Rasterization", GPU Gems 2, chapter 42). The triangle is clipped to each face (I. E. Sutherland and G. W.
/// Hodgman, "Reentrant Polygon Clipping", 1974), and each row of cells takes the extent of what lies within
/// it.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace farshade {

/// Directions from a light to numbered cells: `side` x `side` on each face, row by row.
struct CellFrame {
  /// Cells by which faces and rows are taken wider, since float may count a point into the neighbouring one:
  /// its coordinates err by less than 1e-5 cells.
  static constexpr double kMargin = 1e-3;

  /// Six faces of a cube about `origin`, face 2a along axis a and 2a + 1 against it, x and y the other two
  /// axes in order; cell coordinates are (x / depth + 1) * side / 2. Else one face: x, y (in cells, from the
  /// middle) and depth (metres) are rows * (p - origin).
  bool cube = true;
  int side = 0;
  glm::dvec3 origin{0.0};
  std::array<glm::dvec3, 3> rows{};
  double rounding = 0;  ///< metres by which the traversal may take a triangle to be elsewhere

  [[nodiscard]] int faces() const { return cube ? 6 : 1; }
  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(faces()) * static_cast<std::size_t>(side * side);
  }
};

struct CellTouch {
  std::uint32_t cell;
  float depth;  ///< metres: the triangle comes no nearer than this there
};

/// Appends to `touched` every cell through which the light may see any of the triangle, once each.
void cover(const CellFrame& frame, const std::array<glm::dvec3, 3>& triangle,
           std::vector<CellTouch>& touched);

}  // namespace farshade
