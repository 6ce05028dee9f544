#include "stereo/tracer/surface_model.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "stereo/base/check.h"

namespace farshade {
namespace {

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

double reach_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  return std::max({largest(a), largest(b), largest(c)});
}

/// Largest row sum of absolute values: the largest factor by which a matrix can grow the largest coordinate.
double largest_row_sum(const glm::dmat3& m) {
  const glm::dmat3 rows = glm::transpose(m);
  const auto sum = [](const glm::dvec3& r) { return std::abs(r.x) + std::abs(r.y) + std::abs(r.z); };
  return std::max({sum(rows[0]), sum(rows[1]), sum(rows[2])});
}

/// The factor by which errors may grow when a float matrix carries a ray to object space and the hit point
/// back (R. D. Skeel, "Scaling for numerical stability in Gaussian elimination", 1979). Scaling along the
/// object's axes does not increase it.
double condition(const glm::dmat3& m) {
  const glm::dmat3 inverse = glm::inverse(m);
  const auto absolute = [](const glm::dmat3& a) {
    return glm::dmat3(glm::abs(a[0]), glm::abs(a[1]), glm::abs(a[2]));
  };
  return largest_row_sum(absolute(m) * absolute(inverse));
}

/// Inverse transpose times a positive number. Exists for every matrix.
glm::dmat3 normal_matrix(const glm::dmat3& m) {
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  return glm::determinant(m) < 0 ? -cofactors : cofactors;
}

/// `m`, or a matrix close to it that float can invert. A flattened parent and a turned child make a matrix
/// whose columns lie in one plane, as far as float can tell. They are moved out of it, on their own side, by
/// kLeastThickness of their size. With less, shadow rays would start farther from the surface
/// (Placement::reach).
glm::dmat3 thickened(const glm::dmat3& m) {
  constexpr double kLeastThickness = 1e-3;
  if (condition(m) * kLeastThickness < 1) return m;
  // The plane's normal times the transpose of the flattened direction, nearly.
  const glm::dmat3 out = normal_matrix(m);
  const auto length = [](const glm::dmat3& a) {
    return std::sqrt(glm::dot(a[0], a[0]) + glm::dot(a[1], a[1]) + glm::dot(a[2], a[2]));
  };
  return m + out * (kLeastThickness * length(m) / length(out));
}

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
  const double square = glm::dot(v, v);
  if (square > 1e-200 && square < 1e200) return v * (1.0 / std::sqrt(square));  // nearly always, and quicker
  const double size = largest(v);
  return size > 0 ? glm::normalize(v / size) : glm::dvec3(0.0);
}

/// Computed at the corner opposite to the longest edge, so that a sliver keeps its normal.
glm::dvec3 facet_normal(const std::array<glm::dvec3, 3>& p) {
  const std::array<glm::dvec3, 3> edge{p[2] - p[1], p[0] - p[2], p[1] - p[0]};
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (glm::dot(edge[i], edge[i]) > glm::dot(edge[longest], edge[longest])) longest = i;
  return unit_or_zero(glm::cross(edge[(longest + 1) % 3], edge[(longest + 2) % 3]));
}

}  // namespace

SurfaceModel::SurfaceModel(const Scene& scene, const SceneState& state, const TracePlan& plan)
    : scene_(scene) {
  check_eq(state.stage_from_object.size(), scene.instances.size(), "a state places every instance");
  check_eq(plan.moves.size(), scene.instances.size(), "a plan knows every instance");
  check_eq(plan.surfaces.size(), scene.meshes.size(), "a plan knows every mesh");
  closeup_ = closeup_of(scene);
  anchor_from_stage_ = farshade::anchor_from_stage(closeup_.anchor);
  patches_.reserve(scene.instances.size());
  for (const bool moving : {false, true}) {
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i)
      if (plan.moves[i] == moving) add(scene, state, i, plan);
    if (!moving) fixed_count_ = patches_.size();
  }
  positions_.emplace_back(0.0f);
  place(state);
}

void SurfaceModel::add(const Scene& scene, const SceneState& state, std::uint32_t instance,
                       const TracePlan& plan) {
  const bool moving = plan.moves[instance];
  const SurfaceNeeds& needs = plan.surfaces[scene.instances[instance].mesh];
  const Mesh& mesh = scene.meshes[scene.instances[instance].mesh];
  const Material& material = scene.materials[mesh.material];
  const glm::dmat4& stage_from_object = state.stage_from_object[instance].matrix;
  const glm::dmat3 linear = moving ? glm::dmat3(1.0) : glm::dmat3(stage_from_object);
  if (is_singular(linear)) return;

  Patch patch{.instance = instance,
              .first_triangle = narrow<std::uint32_t>(triangles_.size()),
              .first_vertex = narrow<std::uint32_t>(positions_.size()),
              .double_sided = material.double_sided,
              .back_test = needs.back_test,
              .moving = moving,
              .casts = scene.instances[instance].casts,
              .rig = scene.instances[instance].rig,
              .vertex_count = narrow<std::uint32_t>(mesh.positions.size())};
  if (needs.alpha_test) patch.holes.emplace(scene, mesh);
  if (moving && !patch.rig) {
    const Bounds bounds = bounds_of(mesh.positions);
    patch.object_center = {(bounds.low + bounds.high) * 0.5};
  }

  const Point<Stage> origin{glm::dvec3(stage_from_object[3])};
  const glm::dvec3 shift = moving ? -patch.object_center.v : anchor_from_stage_(origin).v;
  const auto placed = [&](std::uint32_t vertex) {
    return linear * glm::dvec3(mesh.positions[vertex]) + shift;
  };
  const glm::dmat3 normal_from_object = normal_matrix(linear);
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    positions_.emplace_back(placed(v));
    normals_.emplace_back(unit_or_zero(normal_from_object * glm::dvec3(mesh.normals[v])));
  }
  const bool mirrored = glm::determinant(linear) < 0;
  // The hole test needs the mesh's own vertices.
  const bool splits = !moving && !needs.alpha_test && std::isfinite(closeup_.near_m);
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::uvec3 wound = mirrored ? glm::uvec3(t.x, t.z, t.y) : t;
    const std::array<glm::dvec3, 3> p{placed(wound.x), placed(wound.y), placed(wound.z)};
    patch.object_reach = std::max(patch.object_reach, reach_of(p[0], p[1], p[2]));
    if (splits)
      add_split(wound + patch.first_vertex, {Point<Anchor>{p[0]}, {p[1]}, {p[2]}});
    else
      add_triangle(wound + patch.first_vertex, p);
  }
  patch.triangle_count = narrow<std::uint32_t>(triangles_.size()) - patch.first_triangle;
  patches_.push_back(patch);
}

void SurfaceModel::add_triangle(const glm::uvec3& vertices, const std::array<glm::dvec3, 3>& p) {
  triangles_.push_back(vertices);
  facets_.push_back({glm::vec3(facet_normal(p)), static_cast<float>(reach_of(p[0], p[1], p[2]))});
}

void SurfaceModel::add_split(const glm::uvec3& vertices, const std::array<Point<Anchor>, 3>& p) {
  const glm::vec3 normal(facet_normal({p[0].v, p[1].v, p[2].v}));
  const auto keep = [&](const glm::uvec3& its, const std::array<Corner, 3>& part) {
    triangles_.push_back(its);
    facets_.push_back(
        {normal, static_cast<float>(reach_of(part[0].position.v, part[1].position.v, part[2].position.v))});
  };
  const auto corner = [&](int i) {
    return Corner{p[static_cast<std::size_t>(i)], {glm::dvec3(normals_[vertices[i]])}};
  };
  split_graded({corner(0), corner(1), corner(2)}, closeup_.near_m, [&](const std::array<Corner, 3>& part) {
    if (part[0].position == p[0] && part[1].position == p[1] && part[2].position == p[2])
      return keep(vertices, part);
    const auto first = narrow<std::uint32_t>(positions_.size());
    for (const Corner& c : part) positions_.emplace_back(c.position.v), normals_.emplace_back(c.normal.v);
    keep({first, first + 1, first + 2}, part);
  });
}

/// Computes the patch's vertices and facets.
void SurfaceModel::deform(const SceneState& state, Patch& patch) {
  const Mesh& mesh = scene_.meshes[scene_.instances[patch.instance].mesh];
  const auto positions = std::span(positions_).subspan(patch.first_vertex, patch.vertex_count);
  Deformation(*mesh.deformable, state.rigs[*patch.rig])
      .write(positions, std::span(normals_).subspan(patch.first_vertex, patch.vertex_count));
  patch.object_reach = 0;
  for (std::size_t t = patch.first_triangle; t < patch.first_triangle + patch.triangle_count; ++t) {
    const glm::uvec3& v = triangles_[t];
    const std::array<glm::dvec3, 3> p{positions_[v.x], positions_[v.y], positions_[v.z]};
    const double reach = reach_of(p[0], p[1], p[2]);
    facets_[t] = {glm::vec3(facet_normal(p)), static_cast<float>(reach)};
    patch.object_reach = std::max(patch.object_reach, reach);
  }
}

void SurfaceModel::place(const SceneState& state) {
  const auto moving = std::span(patches_).subspan(fixed_count_);
  tbb::parallel_for(std::size_t{0}, moving.size(), [&](std::size_t i) {
    if (moving[i].rig) deform(state, moving[i]);
  });
  for (Patch& patch : moving) {
    const glm::dmat4& m = state.stage_from_object[patch.instance].matrix;
    Placement& placement = patch.placement;
    placement.singular = is_singular(glm::dmat3(m));
    if (placement.singular) continue;
    const glm::dmat3 linear = thickened(glm::dmat3(m));
    const Point<Anchor> translation =
        anchor_from_stage_(Point<Stage>{glm::dmat3(m) * patch.object_center.v + glm::dvec3(m[3])});
    placement.linear = glm::mat3(linear);
    placement.translation = in_float(translation);
    placement.normal = glm::mat3(normal_matrix(linear / largest_row_sum(linear)));
    const double grown = largest_row_sum(linear) * patch.object_reach + largest(translation.v);
    // Twice, for the rounding of the matrix and its inverse. The tests pass with 1, too, but 64 u M leave
    // little for that rounding beside the 35 u M of tile_stages.h.
    placement.reach = static_cast<float>(2.0 * condition(linear) * grown);
  }
}

}  // namespace farshade
