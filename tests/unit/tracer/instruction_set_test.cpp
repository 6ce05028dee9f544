#include "stereo/base/instruction_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "stereo/gltf/gltf.h"
#include "tests/oracle/agreement.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

/// The sets beyond the baseline that this processor and this program have.
std::vector<InstructionSet> larger_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set : {InstructionSet::Avx2, InstructionSet::Avx512})
    if (set <= best_instruction_set()) sets.push_back(set);
  return sets;
}

/// Expects that masks and counts of rays are those of the baseline, with and without skipped rays.
void expect_same_bits(const Scene& scene, const FrameRequest& request) {
  TracePlan plan = plan_for(scene, {.all_lights = true}).trace;
  for (const bool skips_rays : {true, false}) {
    plan.skips_rays = skips_rays;
    Tracer baseline = Tracer::create(scene, plan, InstructionSet::Baseline).value();
    ShadowFrame expected;
    const TraceStats rays = baseline.trace(request, expected);
    ASSERT_GT(rays.shadow_rays, 0u);
    for (const InstructionSet set : larger_sets()) {
      Tracer tracer = Tracer::create(scene, plan, set).value();
      ShadowFrame frame;
      const TraceStats stats = tracer.trace(request, frame);
      EXPECT_EQ(frame.masks, expected.masks) << static_cast<int>(set);
      EXPECT_EQ(stats.shadow_rays, rays.shadow_rays);
    }
  }
}

TEST(TracerInstructionSets, GiveTheSameBitsInRandomSoups) {
  if (larger_sets().empty()) GTEST_SKIP() << "the processor or the program has no larger set";
  const unsigned seed = 20270401;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int i = 0; i < 8; ++i) {
    SCOPED_TRACE(i);
    const Scene scene = random_soup(random);
    const double angle = 0.8 * i;
    const glm::dvec3 eye(2.5 * std::sin(angle), 0.3, 2.5 * std::cos(angle));
    expect_same_bits(scene, request_for({look(eye, {0.1, -0.8, 0}, 150),
                                         look(eye + glm::dvec3(0, 0.06, 0), {0.1, -0.8, 0}, 150)}));
  }
}

TEST(TracerInstructionSets, GiveTheSameBitsInTheRoom) {
  if (larger_sets().empty()) GTEST_SKIP() << "the processor or the program has no larger set";
  const Scene scene = load_scene(FARSHADE_ASSETS "/room.glb").value();
  const Rigid<Stage, Eye> camera = scene.camera.value();
  StereoView views;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    views[eye] = {{camera.rotation, camera(Point<Eye>{{eye == 0 ? -0.032 : 0.032, 0, 0}}).v},
                  {-0.8, 0.8, 0.74, -0.85},
                  {200, 136}};
  expect_same_bits(scene, request_for(views, time_from_ns(1'300'000'000)));
}

TEST(InstructionSet, IsChosenOnlyInProgramsThatAreNotCompiledForAvx2) {
#if FARSHADE_CHOOSES_INSTRUCTIONS
  EXPECT_EQ(best_instruction_set() >= InstructionSet::Avx2, __builtin_cpu_supports("avx2") != 0);
#else
  EXPECT_EQ(best_instruction_set(), InstructionSet::Baseline);
#endif
}

}  // namespace
}  // namespace farshade
