#include "stereo/tracer/placed_surface.h"

#include <numbers>
#include <optional>

namespace farshade {
namespace {

constexpr int kFarthest_px = 8;  ///< distance of the farthest neighbours that are tried
constexpr int kSide = static_cast<int>(kTileSide_px) + 2 * kFarthest_px;

/// Positions of a tile and of a border around it, in anchor space.
struct Neighbourhood {
  std::array<glm::vec3, std::size_t{kSide} * kSide> position;
  std::array<bool, std::size_t{kSide} * kSide> covered;

  /// Index of a pixel of the tile, or of one up to kFarthest_px beside it.
  [[nodiscard]] static std::size_t at(int x, int y) {
    return static_cast<std::size_t>((y + kFarthest_px) * kSide + x + kFarthest_px);
  }
};

void load(const PlacedEye& eye, const TileRect& rect, Neighbourhood& out) {
  const Extent size = eye.planes[0].size;
  out.covered.fill(false);
  for (int y = -kFarthest_px; y < kSide - kFarthest_px; ++y)
    for (int x = -kFarthest_px; x < kSide - kFarthest_px; ++x) {
      const std::int64_t column = std::int64_t{rect.x0} + x, row = std::int64_t{rect.y0} + y;
      if (column < 0 || row < 0 || column >= size.width || row >= size.height) continue;
      const auto i = static_cast<std::size_t>(row * size.width + column);
      const std::uint32_t word = eye.planes[0].words[i];
      if (word == 0) continue;
      const glm::dvec3 steps(word - 1.0, eye.planes[1].words[i] - 1.0, eye.planes[2].words[i] - 1.0);
      out.position[Neighbourhood::at(x, y)] = glm::vec3(eye.low.v + steps * eye.step);
      out.covered[Neighbourhood::at(x, y)] = true;
    }
}

/// An estimate of the plane of a pixel's surface.
struct Estimate {
  glm::vec3 normal;  ///< unit
  float tilt = 0;    ///< sine of the normal's largest possible error
  bool sure =
      false;  ///< the neighbours on all sides lie in the plane, and it is certain which side the eye sees
};

/// The difference to the nearer of the two neighbours along one axis. The other may lie on another surface.
std::optional<glm::vec3> shorter_step(const Neighbourhood& around, int x, int y, int dx, int dy) {
  const std::size_t here = Neighbourhood::at(x, y);
  const std::size_t ahead = Neighbourhood::at(x + dx, y + dy), behind = Neighbourhood::at(x - dx, y - dy);
  const glm::vec3 forth = around.position[ahead] - around.position[here];
  const glm::vec3 back = around.position[here] - around.position[behind];
  if (!around.covered[ahead] && !around.covered[behind]) return std::nullopt;
  if (!around.covered[behind]) return forth;
  if (!around.covered[ahead]) return back;
  return glm::dot(forth, forth) <= glm::dot(back, back) ? forth : back;
}

/// Whether the neighbours on all sides lie in the plane.
bool is_flat(const Neighbourhood& around, int x, int y, int away, const glm::vec3& normal, float doubt) {
  const glm::vec3 here = around.position[Neighbourhood::at(x, y)];
  for (const auto& [dx, dy] : {std::pair{away, 0}, {-away, 0}, {0, away}, {0, -away}}) {
    const std::size_t there = Neighbourhood::at(x + dx, y + dy);
    if (!around.covered[there]) return false;
    if (std::abs(glm::dot(normal, around.position[there] - here)) > 2 * doubt) return false;
  }
  return true;
}

/// The first estimate whose tilt is smaller than the angle between the plane and the direction to the eye, so
/// that it is certain which side the eye sees. If there is none, the last estimate that is tilted by at most
/// 60 degrees.
std::optional<Estimate> estimate(const Neighbourhood& around, int x, int y, const glm::vec3& to_eye,
                                 float doubt) {
  std::optional<Estimate> found;
  for (int away = 1; away <= kFarthest_px; away *= 2) {
    const auto across = shorter_step(around, x, y, away, 0), down = shorter_step(around, x, y, 0, away);
    if (!across || !down) continue;
    glm::vec3 normal = glm::cross(*across, *down);
    const float area = glm::length(normal);
    const float longer = std::max(glm::length(*across), glm::length(*down));
    if (!(longer >= 2 * doubt && area >= 2 * doubt * longer)) continue;
    normal /= area;
    // asin(a) + asin(b), as its sine
    const float a = doubt / longer, b = doubt * longer / area;
    const float tilt = a * std::sqrt(1 - b * b) + b * std::sqrt(1 - a * a);
    const bool sided = std::abs(glm::dot(normal, to_eye)) > tilt;
    found = Estimate{normal, tilt, sided && is_flat(around, x, y, away, normal, doubt)};
    if (sided) break;
  }
  return found;
}

/// How a ray's start is lifted off its surface against rounding of float.
struct Lift {
  glm::vec3 along;    ///< unit
  float cosine = 1;   ///< of the angle between `along` and the surface's normal, at least
  float tilt = 2.0f;  ///< as PlacedSurface::tilt
};

/// The cosine that is assumed at least, if the estimate is uncertain or if there is none.
constexpr float kLeastCosine = 0.125f;

Lift lift_of(const std::optional<Estimate>& found, const glm::vec3& to_eye) {
  if (!found) return {.along = to_eye, .cosine = kLeastCosine};
  const float seen = glm::dot(found->normal, to_eye);
  if (!found->sure) return {.along = to_eye, .cosine = std::max(std::abs(seen), kLeastCosine)};
  return {.along = seen < 0 ? -found->normal : found->normal,
          .cosine = std::sqrt(1 - found->tilt * found->tilt),
          .tilt = found->tilt};
}

/// Writes the surface of one covered pixel into pixel `at` of `out`.
void resolve(const PlacedEye& eye, const TileRect& rect, const Neighbourhood& around, TilePixel pixel,
             PlacedSurface& out, int at) {
  constexpr float kRounding = 4.0f / (1 << 24);  // two positions' coordinates, each rounded by half an ulp
  const float error =
      0.5f * std::numbers::sqrt3_v<float> * (static_cast<float>(eye.step) + kRounding * eye.reach);  // E
  const glm::vec3 ray(eye.rays.corner + eye.rays.across * (rect.x0 + pixel.x + 0.5) +
                      eye.rays.down * (rect.y0 + pixel.y + 0.5));
  const glm::vec3& origin = eye.rays.origin.v;
  const glm::vec3 on_grid = around.position[Neighbourhood::at(pixel.x, pixel.y)];
  const float along_ray = std::max(glm::dot(on_grid - origin, ray) / glm::dot(ray, ray), 0.0f);
  const float length = glm::length(ray);
  const glm::vec3 p = origin + ray * along_ray, to_eye = -ray / length;
  const Lift lift = lift_of(estimate(around, pixel.x, pixel.y, to_eye, 2 * error), to_eye);
  const glm::vec3& n = lift.along;
  const glm::vec3 start =
      p + to_eye * std::min(error, along_ray * length) + n * (kOffset * eye.reach / lift.cosine);
  out.px[at] = p.x, out.py[at] = p.y, out.pz[at] = p.z;
  out.ox[at] = start.x, out.oy[at] = start.y, out.oz[at] = start.z;
  out.nx[at] = out.gx[at] = n.x, out.ny[at] = out.gy[at] = n.y, out.nz[at] = out.gz[at] = n.z;
  out.reach[at] = eye.reach;
  out.tilt[at] = lift.tilt;
}

}  // namespace

void place_tile(const PlacedEye& eye, const TileRect& rect, PlacedSurface& out) {
  Neighbourhood around;
  load(eye, rect, around);
  out.covered = 0;
  for (int i = 0; i < kTilePixels; ++i) {
    const TilePixel pixel = kTileOrder[static_cast<std::size_t>(i)];
    const bool inside = pixel.x < rect.x1 - rect.x0 && pixel.y < rect.y1 - rect.y0;
    if (!inside || !around.covered[Neighbourhood::at(pixel.x, pixel.y)]) {
      resolve_miss(out, i);
      out.tilt[i] = 0;
      continue;
    }
    ++out.covered;
    resolve(eye, rect, around, pixel, out, i);
  }
}

}  // namespace farshade
