/// The motion data of shade.comp: one flag and two sets of stale lights and spheres, for the newest mask and
/// for all older masks together.
#include "stereo/reproject/shading_motion.h"

#include <gtest/gtest.h>

#include <glm/ext/matrix_transform.hpp>

#include "stereo/math/rotation.h"
#include "stereo/reproject/shading_layout.h"

namespace farshade {
namespace {

constexpr std::size_t kMasks = 3, kSlots = 2;

StereoView some_views() {
  StereoView views;
  views[0] = {{rotation_exp({0.2, 0.5, -0.1}), {1, 2, 3}}, {-0.7, 0.8, 0.6, -0.5}, {64, 32}};
  views[1] = {{rotation_exp({-0.1, 0.4, 0.3}), {4, -2, 1}}, {-0.7, 0.8, 0.6, -0.5}, {64, 32}};
  return views;
}

/// A motion in which the instances of `slots` have moved by 1 m times their slot + 1 along x.
Motion moved_slots(const std::vector<std::size_t>& slots) {
  Motion motion;
  motion.then_from_now.resize(kSlots);
  for (const std::size_t slot : slots)
    motion.then_from_now[slot] =
        glm::translate(glm::dmat4(1.0), {-1.0 * static_cast<double>(slot + 1), 0, 0});
  return motion;
}

struct Written {
  std::vector<glm::mat4> matrices = std::vector<glm::mat4>(kSlots * FARSHADE_MAX_TRACED * kEyes);
  [[nodiscard]] float flag(std::size_t slot, std::size_t mask) const {
    EXPECT_EQ(matrices[motion_index(slot, mask, 0)][0][3], matrices[motion_index(slot, mask, 1)][0][3]);
    return matrices[motion_index(slot, mask, 0)][0][3];
  }
};

std::vector<const Motion*> pointers(const std::vector<Motion>& motions) {
  std::vector<const Motion*> result;
  for (const Motion& motion : motions) result.push_back(&motion);
  return result;
}

Written written(const std::vector<Motion>& motions, const std::vector<Motion>& cube_mask = {}) {
  const auto since = pointers(motions), since_faces = pointers(cube_mask);
  Written result;
  for (std::size_t slot = 0; slot < kSlots; ++slot)
    write_motions(some_views(), {since, since_faces}, slot, WriteOnly(std::span(result.matrices)));
  return result;
}

TEST(ShadingMotion, TheBufferHasTheMatricesOfEveryMaskWithAndWithoutACubeMask) {
  for (const bool cube_mask : {false, true}) {
    DrawPlan plan;
    plan.mask = {.lights = 2};
    plan.moves = {true, false, true};
    plan.cube_mask = cube_mask;
    const std::size_t last = motion_index(1, FARSHADE_MAX_TRACED - 1, kEyes - 1);
    EXPECT_GE(shading_bytes(plan, {8, 8}, {8, 8}).motions, (last + 1) * sizeof(glm::mat4)) << cube_mask;
  }
}

TEST(ShadingMotion, TheCubeMaskIsAGroupOfItsOwn) {
  const Written result = written({moved_slots({}), moved_slots({})}, {moved_slots({}), moved_slots({0})});
  EXPECT_EQ(result.flag(0, 0), 0);
  EXPECT_EQ(result.flag(0, 1), 0);
  EXPECT_EQ(result.flag(0, FARSHADE_MAX_MASKS), 1) << "the flag of a group is in its first matrices";
  EXPECT_EQ(result.flag(0, FARSHADE_MAX_MASKS + 1), 1);
  EXPECT_EQ(result.flag(1, FARSHADE_MAX_MASKS), 0) << "another instance";
  EXPECT_EQ(result.matrices[motion_index(0, FARSHADE_MAX_MASKS, 0)][3], glm::vec4(0, 0, 0, 1))
      << "has not moved since";
  EXPECT_NE(result.matrices[motion_index(0, FARSHADE_MAX_MASKS + 1, 0)][3], glm::vec4(0, 0, 0, 1));
}

TEST(ShadingMotion, TheFlagOfOlderMasksIsSetIfTheInstanceHasMovedSinceAnyOfThem) {
  for (std::size_t moved = 0; moved < kMasks; ++moved) {
    std::vector<Motion> motions(kMasks, moved_slots({}));
    motions[moved] = moved_slots({1});
    const Written result = written(motions);
    EXPECT_EQ(result.flag(1, 0), moved == 0 ? 1 : 0) << "since the newest; moved since mask " << moved;
    EXPECT_EQ(result.flag(1, 1), moved > 0 ? 1 : 0) << "since an older one; moved since mask " << moved;
    EXPECT_EQ(result.flag(0, 0), 0) << "another instance";
    EXPECT_EQ(result.flag(0, 1), 0) << "another instance";
  }
}

TEST(ShadingMotion, MatricesMoveAPointOfTheShownEyeToWhereItWas) {
  const StereoView views = some_views();
  const Written result = written({moved_slots({0}), moved_slots({}), moved_slots({1})});
  const Point<Eye> p{{0.3, -0.4, -2}};
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const auto carried = [&](std::size_t slot, std::size_t mask) {
      glm::mat4 then_from_now = result.matrices[motion_index(slot, mask, eye)];
      then_from_now[0][3] = 0;
      return glm::dvec3(then_from_now * glm::vec4(p.v, 1.0));
    };
    const auto expected = [&](double travel) {
      const Point<Stage> now = views[eye].stage_from_eye(p);
      return inverse(views[eye].stage_from_eye)(Point<Stage>{now.v - glm::dvec3(travel, 0, 0)}).v;
    };
    EXPECT_LT(glm::length(carried(0, 0) - expected(1)), 1e-5);
    EXPECT_LT(glm::length(carried(0, 1) - p.v), 1e-6) << "it has not moved since this mask";
    EXPECT_LT(glm::length(carried(1, 2) - expected(2)), 1e-5);
  }
}

gpu::FrameData frame_of(const std::vector<Motion>& motions, bool& any) {
  const auto since = pointers(motions);
  gpu::FrameData frame{};
  any = write_stale(some_views(), {.masks = since}, frame);
  return frame;
}

bool is_stale(const gpu::FrameData& frame, std::size_t group, std::size_t light) {
  return (frame.stale_lights[group * 2 + light / 128][static_cast<int>(light / 32 % 4)] >> light % 32 & 1u) !=
         0;
}

TEST(ShadingMotion, StaleLightsOfTheNewestAndOfAllOlderMasksAreKeptApart) {
  std::vector<Motion> motions(kMasks);
  motions[0].stale_lights.set(3);
  motions[1].stale_lights.set(40);
  motions[2].stale_lights.set(255);
  motions[2].changed_lights.set(255);
  bool any = false;
  const gpu::FrameData frame = frame_of(motions, any);
  for (std::size_t light = 0; light < kMaxLights; ++light) {
    EXPECT_EQ(is_stale(frame, 0, light), light == 3) << light;
    EXPECT_EQ(is_stale(frame, 1, light), light == 40 || light == 255) << light;
  }
  EXPECT_EQ(frame.changed_lights[1], glm::uvec4(0, 0, 0, 1u << 31));
  EXPECT_EQ(frame.changed_lights[0], glm::uvec4(0));
  EXPECT_TRUE(any);
}

TEST(ShadingMotion, SpheresAreRelativeToEachEyeAndUnusedOnesHaveNegativeRadius) {
  std::vector<Motion> motions(kMasks);
  motions[2].moved = {{Point<Stage>{{5, 6, 7}}, 2}, {Point<Stage>{{-5, 0, 0}}, 0.5}};
  bool any = false;
  const gpu::FrameData frame = frame_of(motions, any);
  const StereoView views = some_views();
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t i = 0; i < kMostSpheres; ++i) {
      EXPECT_LT(frame.moved[eye * kMostSpheres + i].w, 0) << "nothing has moved since the newest mask";
      const glm::vec4 sphere = frame.moved[(kEyes + eye) * kMostSpheres + i];
      if (i >= 2) {
        EXPECT_LT(sphere.w, 0);
        continue;
      }
      const Sphere& given = motions[2].moved[i];
      const glm::dvec3 centre = given.centre.v - views[eye].stage_from_eye.translation;
      EXPECT_LT(glm::length(glm::dvec3(sphere) - centre), 1e-5);
      EXPECT_EQ(sphere.w, static_cast<float>(given.radius * given.radius));
    }
  EXPECT_TRUE(any);
}

TEST(ShadingMotion, WithoutMasksOrMotionNothingIsStale) {
  for (const std::size_t masks : {std::size_t{0}, kMasks}) {
    bool any = false;
    const gpu::FrameData frame = frame_of(std::vector<Motion>(masks), any);
    EXPECT_FALSE(any);
    for (const glm::vec4& sphere : frame.moved) EXPECT_LT(sphere.w, 0);
  }
}

}  // namespace
}  // namespace farshade
