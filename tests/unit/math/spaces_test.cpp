#include "stereo/math/spaces.h"

#include <gtest/gtest.h>

#include "stereo/math/rotation.h"

namespace farshade {
namespace {

// These expressions must not compile: transforms between different spaces, and sums without a meaning.
template <class A, class B>
concept Composes = requires(A a, B b) {
  a* b;
};
template <class Map, class Of>
concept Maps = requires(Map map, Of of) {
  map(of);
};
template <class A, class B>
concept Subtracts = requires(A a, B b) {
  a - b;
};
template <class A, class B>
concept Adds = requires(A a, B b) {
  a + b;
};

static_assert(Composes<Rigid<Stage, Head>, Rigid<Head, Eye>>);
static_assert(!Composes<Rigid<Head, Eye>, Rigid<Stage, Head>>, "swapped");
static_assert(!Composes<Rigid<Stage, Head>, Rigid<Stage, Head>>);
static_assert(Composes<Rigid<Stage, Head>, Affine<Head, Object>>);
static_assert(!Composes<Rigid<Stage, Head>, Affine<Stage, Object>>);
static_assert(!Composes<Affine<Stage, Object>, Affine<Stage, Object>>);
static_assert(Maps<Rigid<Stage, Eye>, Point<Eye>> && Maps<Rigid<Stage, Eye>, Vector<Eye>>);
static_assert(!Maps<Rigid<Stage, Eye>, Point<Stage>> && !Maps<Rigid<Stage, Eye>, Vector<Head>>);
static_assert(Subtracts<Point<Stage>, Point<Stage>> && !Subtracts<Point<Stage>, Point<Eye>>);
static_assert(Adds<Point<Stage>, Vector<Stage>> && !Adds<Point<Stage>, Point<Stage>>);
static_assert(std::is_same_v<decltype(Point<Stage>{} - Point<Stage>{}), Vector<Stage>>);
static_assert(std::is_same_v<decltype(Rigid<Stage, Head>{} * Rigid<Head, Eye>{}), Rigid<Stage, Eye>>);
static_assert(std::is_same_v<decltype(inverse(Rigid<Stage, Eye>{})), Rigid<Eye, Stage>>);

const Rigid<Stage, Head> stage_from_head{rotation_exp({0.1, 2.0, -0.3}), {4, 1.6, -7}};
const Rigid<Head, Eye> head_from_eye{rotation_exp({0, 0.05, 0}), {-0.032, 0.01, 0}};
const Point<Eye> point{{0.3, -0.2, -5}};

TEST(Rigid, RotatesThenMoves) {
  const Rigid<Stage, Eye> turned{rotation_exp({0, 3.14159265358979323846 / 2, 0}), {10, 0, 0}};
  EXPECT_LE(length(turned(Point<Eye>{{0, 0, -1}}) - Point<Stage>{{9, 0, 0}}), 1e-15);
  EXPECT_LE(length(turned(Vector<Eye>{{0, 0, -1}}) + Vector<Stage>{{1, 0, 0}}), 1e-15);
}

TEST(Rigid, ComposesAsMapsDo) {
  const auto stage_from_eye = stage_from_head * head_from_eye;
  EXPECT_LE(length(stage_from_eye(point) - stage_from_head(head_from_eye(point))), 1e-14);
}

TEST(Rigid, InverseGoesBack) {
  EXPECT_LE(length(inverse(stage_from_head)(stage_from_head(head_from_eye(point))) - head_from_eye(point)),
            1e-14);
  const auto same = inverse(stage_from_head) * stage_from_head;
  EXPECT_LE(glm::length(same.translation), 1e-14);
  EXPECT_LE(angle_between_rad(same.rotation, glm::dquat(1, 0, 0, 0)), 1e-15);
}

TEST(Rigid, StaysUnitThroughLongChains) {
  Rigid<Stage, Stage> chain;
  const Rigid<Stage, Stage> step{rotation_exp({0.01, 0.02, -0.03}), {}};
  for (int i = 0; i < 100'000; ++i) chain = chain * step;
  EXPECT_NEAR(glm::length(chain.rotation), 1.0, 1e-15);
}

TEST(Rigid, KeepsMillimetresAThousandKilometresOut) {
  const Rigid<Stage, Eye> far_away{rotation_exp({0.1, 2.0, -0.3}), {1e6, 0, -1e6}};
  EXPECT_LE(length(inverse(far_away)(far_away(point)) - point), 1e-9);
}

TEST(RigidMatrix, MapsAsTheTransformDoes) {
  const glm::dvec4 mapped = matrix(head_from_eye) * glm::dvec4(point.v, 1.0);
  EXPECT_LE(glm::length(glm::dvec3(mapped) - head_from_eye(point).v), 1e-14);
  EXPECT_EQ(mapped.w, 1.0);
}

TEST(Affine, ComposesWithRigid) {
  Affine<Head, Object> head_from_object;
  head_from_object.matrix[0][0] = -2.0;  // a mirror, as glTF allows
  head_from_object.matrix[3] = {1, 2, 3, 1};
  const Affine<Stage, Object> stage_from_object = stage_from_head * head_from_object;
  const Point<Object> p{{1, 1, 1}};
  EXPECT_LE(length(stage_from_object(p) - stage_from_head(head_from_object(p))), 1e-14);
  const Vector<Object> d{{1, 0, 0}};
  EXPECT_LE(length(head_from_object(d) + Vector<Head>{{2, 0, 0}}), 0.0);
}

}  // namespace
}  // namespace farshade
