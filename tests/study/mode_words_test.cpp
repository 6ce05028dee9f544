#include "tests/study/mode_words.h"
#include "stereo/gpu/device.h"

#include <gtest/gtest.h>

namespace farshade::study {
namespace {

/// A play for tests of settings only.
struct Settings {
  gpu::Device device;
  Scene scene;
  HeadRecording head;
  Play play{.device = device, .scene = scene, .head = head};
};

Expected<void> set(const char* words, Settings& settings) {
  return set_mode(words, settings.play);
}

TEST(ModeWords, ANameAloneIsTheModeWithItsDefaults) {
  for (const ModeName& named : kModes) {
    Settings settings;
    ASSERT_TRUE(set_mode(named.name, settings.play));
    ModeSettings by_default;
    by_default.mode = named.mode;
    EXPECT_EQ(settings.play.mode, by_default);
    EXPECT_EQ(settings.play.reprojection, Reprojection{});
    EXPECT_EQ(settings.play.mask_wait, Duration::zero());
    EXPECT_FALSE(settings.play.detail_px.has_value());
  }
}

TEST(ModeWords, SetTheNamedSetting) {
  Settings hybrid;
  ASSERT_TRUE(
      set("hybrid,ask=whole,reprojection=off,band=off,eyes=this,gaps=unknown,edges=nearest,predictor=hold,"
          "every=4,wait",
          hybrid));
  EXPECT_EQ(hybrid.play.reprojection,
            (Reprojection{Lookup::Direct, Eyes::This, Gaps::Unknown, Edges::Nearest}));
  EXPECT_EQ(hybrid.play.request.guard_band, GuardBandUse::Off);
  EXPECT_EQ(hybrid.play.request.asks, Asks::Whole);
  EXPECT_EQ(hybrid.play.request.predictor, PredictorKind::Hold);
  EXPECT_EQ(hybrid.play.request.every, 4u);
  EXPECT_GT(hybrid.play.mask_wait, Duration::zero());

  Settings blocks;
  ASSERT_TRUE(set("hybrid,code=lz4", blocks));
  EXPECT_EQ(blocks.play.mode.mask_code, MaskCode::Lz4);

  Settings covered;
  ASSERT_TRUE(set("hybrid,edges=coverage", covered));
  EXPECT_EQ(covered.play.reprojection.edges, Edges::Coverage);

  Settings remote, delta, positions, local;
  ASSERT_TRUE(set("remote,bitrate=20M", remote));
  EXPECT_EQ(remote.play.mode.bits_per_second, 20'000'000u);
  ASSERT_TRUE(set("delta,bitrate=500K", delta));
  EXPECT_EQ(delta.play.mode.bits_per_second, 500'000u);
  ASSERT_TRUE(set("client-positions,bits=12", positions));
  EXPECT_EQ(positions.play.mode.position_bits, 12u);
  ASSERT_TRUE(set("local,maps=2048,pcf=0,redraw=always", local));
  EXPECT_EQ(local.play.mode.shadow_maps, (ShadowMapSettings{2048, 0, Redraw::Always}));
}

TEST(ModeWords, SetTheDetailOfModesThatDrawTheScene) {
  for (const char* name : {"hybrid", "client-positions", "delta", "local", "full"}) {
    Settings quarter, full;
    ASSERT_TRUE(set((std::string(name) + ",detail=0.25").c_str(), quarter)) << name;
    EXPECT_EQ(quarter.play.detail_px, 0.25f);
    ASSERT_TRUE(set((std::string(name) + ",detail=0").c_str(), full)) << name;
    EXPECT_EQ(full.play.detail_px, 0.0f);
  }
}

TEST(ModeWords, RefuseSettingsThatTheModeLacks) {
  for (const char* words : {"",
                            "hybird",
                            "hybrid,eyes",
                            "hybrid,eyes=",
                            "hybrid,eyes=both",
                            "hybrid,code=range",
                            "client-positions,code=lz4",
                            "hybrid,every=0",
                            "hybrid,every=2x",
                            "hybrid,bitrate=20M",
                            "hybrid,wait=1",
                            "remote,bitrate=20G",
                            "remote,bitrate=1",
                            "remote,bitrate=99999999999M",
                            "remote,eyes=this",
                            "client-positions,bits=25",
                            "local,maps=16",
                            "local,every=2",
                            "full,wait",
                            "full,=",
                            "hybrid,predictor=oracle",
                            "hybrid,detail",
                            "hybrid,detail=",
                            "hybrid,detail=-1",
                            "hybrid,detail=nan",
                            "hybrid,detail=16.5",
                            "hybrid,detail=1px",
                            "remote,detail=0",
                            "server-gbuffer,detail=0"}) {
    Settings settings;
    const Expected<void> done = set(words, settings);
    ASSERT_FALSE(done) << words;
    EXPECT_EQ(done.error().fault, Fault::Malformed);
  }
}

}  // namespace
}  // namespace farshade::study
