#include "tests/oracle/agreement.h"

#include <gtest/gtest.h>

namespace farshade {

FrameRequest request_for(const StereoView& views, Time scene_time, FrameId frame) {
  FrameRequest request;
  request.frame = frame;
  request.scene_time = scene_time;
  request.views = views;
  return request;
}

namespace {

ShadowFrame traced_by(Expected<Tracer> tracer, const StereoView& views, Time scene_time) {
  EXPECT_TRUE(tracer) << tracer.error().what;
  ShadowFrame frame;
  if (tracer) tracer->trace(request_for(views, scene_time), frame);
  return frame;
}

}  // namespace

ShadowFrame traced(const Scene& scene, const StereoView& views, Time scene_time) {
  return traced_by(Tracer::create(scene), views, scene_time);
}

ShadowFrame reference_traced(const Scene& scene, const StereoView& views, Time scene_time) {
  return traced_by(Tracer::create_reference(scene), views, scene_time);
}

ShadowFrame traced(const Scene& scene, const View& view, Time scene_time) {
  return traced(scene, StereoView{view, view}, scene_time);
}

oracle::Agreement expect_agrees(const Scene& scene, const StereoView& views, Time scene_time,
                                double most_in_band) {
  const ShadowFrame frame = traced(scene, views, scene_time);
  const SceneState state = state_at(scene, scene_time);
  oracle::Agreement sum;
  for (const Side side : kSides) {
    const View& view = views[index_of(side)];
    const oracle::Agreement a =
        oracle::compare(frame.masks[index_of(side)], oracle::trace(scene, state, view));
    EXPECT_EQ(a.wrong, 0u) << "outside the band, " << name_of(side) << " eye, at pixel " << a.wrong_x << ", "
                           << a.wrong_y << ", light " << a.wrong_light;
    EXPECT_LE(a.band_share(), most_in_band) << name_of(side) << " eye";
    EXPECT_LE(a.wrong_in_band * 10, a.in_band) << name_of(side) << " eye";
    sum.pixel_lights += a.pixel_lights, sum.lit += a.lit, sum.in_band += a.in_band;
    sum.wrong_in_band += a.wrong_in_band, sum.wrong += a.wrong;
    if (views[0] == views[1]) break;
  }
  return sum;
}

}  // namespace farshade
