// Reads a dump as another program would: from its files only, with its own implementation of the geometry.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "stereo/frame/view.h"
#include "stereo/gltf/gltf.h"
#include "stereo/head/reader.h"
#include "stereo/image/difference.h"
#include "stereo/scene/scene_state.h"
#include "tests/integration/client_program.h"
#include "tests/support/image_reader.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

using nlohmann::json;

View view_of(const json& described) {
  const json& pose = described["stage_from_eye"];
  const auto p = pose["position_m"].get<std::array<double, 3>>();
  const auto q = pose["rotation_xyzw"].get<std::array<double, 4>>();
  const json& fov = described["fov_rad"];
  const auto size = described["size_px"].get<std::array<std::uint32_t, 2>>();
  return {{glm::dquat(q[3], q[0], q[1], q[2]), {p[0], p[1], p[2]}},
          {fov["left"], fov["right"], fov["up"], fov["down"]},
          {size[0], size[1]}};
}

StereoView views_of(const json& described) {
  return {view_of(described["left"]), view_of(described["right"])};
}

struct DumpedEye {
  Image<std::uint16_t> traced, shown_mask;
  Image<float> distance;
  Image<Rgb8> shown, reference;
};

/// The position and distance in `other` of the surface that pixel (x, y) of `view` shows.
struct ProjectedPixel {
  std::uint32_t x, y;
  double distance;
};
std::optional<ProjectedPixel> pixel_in(const View& other, const View& view, const Image<float>& distance,
                                       std::uint32_t x, std::uint32_t y) {
  const glm::dvec3 ray = pixel_ray(tangents_of(view.fov), view.size, {x + 0.5, y + 0.5});
  const Point<Stage> surface = view.stage_from_eye(Point<Eye>{ray * double{distance.at(x, y)}});
  const Point<Eye> p = inverse(other.stage_from_eye)(surface);
  if (p.v.z >= 0) return std::nullopt;
  const glm::dvec2 pixel = ray_pixel(tangents_of(other.fov), other.size, p.v);
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= other.size.width || pixel.y >= other.size.height)
    return std::nullopt;
  return ProjectedPixel{static_cast<std::uint32_t>(pixel.x), static_cast<std::uint32_t>(pixel.y), -p.v.z};
}

class ClientDump : public testing::Test {
 protected:
  /// Frame 5 of a run with a delay of 20 ms. It shows masks that frame 3 requested, here for the views that
  /// frame 3 showed.
  void SetUp() override { dump({{"--predictor", "hold"}, {"--guard-band", "off"}}); }

  void dump(std::map<std::string, std::string> options) {
    options.insert({{"--dump", "5"}, {"--frames", "6"}, {"--out", folder_.path().string()}});
    const RunningServer server;
    options["--server"] = server.address();
    const Ended run = run_client(options);
    ASSERT_EQ(run.status, 0) << run.errors;
    const std::filesystem::path inside = folder_.path() / "dump" / "frame_0005";
    EXPECT_EQ(files_below(inside).size(), 17u);
    described_ = json::parse(std::ifstream(inside / "views.json"));
    shown_ = views_of(described_["shown"]["views"]);
    traced_ = views_of(described_["traced"]["views"]);
    for (const Side side : kSides) {
      const auto path = [&](const char* what) { return inside / (std::string(name_of(side)) + "_" + what); };
      eyes_[index_of(side)] = {read_png16(path("mask_traced.png")).value(),
                               read_png16(path("mask_shown.png")).value(),
                               read_pfm(path("distance.pfm")).value(), read_png(path("shown.png")).value(),
                               read_png(path("reference.png")).value()};
    }
  }

  /// Calls `visit` for each covered pixel of an eye.
  void for_covered(std::size_t eye, const std::function<void(std::uint32_t, std::uint32_t)>& visit) const {
    for (std::uint32_t y = 0; y < kClientSize.height; ++y)
      for (std::uint32_t x = 0; x < kClientSize.width; ++x)
        if (eyes_[eye].distance.at(x, y) > 0) visit(x, y);
  }

  ScratchFolder folder_;
  json described_;
  StereoView shown_, traced_;
  PerEye<DumpedEye> eyes_;
};

TEST_F(ClientDump, StatesFramesAndTimesOfBothViews) {
  const json &shown = described_["shown"], &traced = described_["traced"];
  EXPECT_EQ(shown["frame"], 5);
  EXPECT_EQ(traced["frame"], 3);
  const auto ns = [](const json& view) { return view["display_time_ns"].get<std::int64_t>(); };
  EXPECT_EQ(ns(shown) - ns(traced), 27'777'778) << "two display frames";
  EXPECT_EQ(shown["scene_time_ns"], 55'555'556);
}

TEST_F(ClientDump, StatesTheViewsOfTheHeadRecording) {
  const HeadRecording recording = load_head_recording(kWalk, {}).value();
  for (const StereoView& views : {shown_, traced_}) {
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      EXPECT_EQ(views[eye].fov, recording.fov[eye]);
      EXPECT_EQ(views[eye].size, kClientSize);
      EXPECT_TRUE(is_valid(views[eye]));
    }
    const Point<Eye> right =
        inverse(views[0].stage_from_eye)(Point<Stage>{views[1].stage_from_eye.translation});
    EXPECT_LT(glm::length(right.v - glm::dvec3(recording.eye_distance_m, 0, 0)), 1e-9);
  }
  EXPECT_NE(shown_, traced_);
}

/// The default settings: frame 3 requests masks for the views predicted for frame 5, with a guard band.
class PredictedClientDump : public ClientDump {
 protected:
  void SetUp() override { dump({}); }
};

TEST_F(PredictedClientDump, TracedViewsArePredictedForTheDisplayTime) {
  const json &shown = described_["shown"], &traced = described_["traced"];
  EXPECT_EQ(shown["frame"], 5);
  EXPECT_EQ(traced["frame"], 3);
  const auto ns = [](const json& view) { return view["display_time_ns"].get<std::int64_t>(); };
  EXPECT_NEAR(static_cast<double>(ns(shown) - ns(traced)), 0, 2);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const View &view = shown_[eye], &wide = traced_[eye];
    EXPECT_TRUE(is_valid(wide));
    EXPECT_GE(wide.size.width, view.size.width);
    EXPECT_GE(wide.size.height, view.size.height);
    EXPECT_GT(wide.size.pixels(), view.size.pixels()) << "there is a guard band";
    EXPECT_LE(wide.fov.left_rad, view.fov.left_rad + 1e-9);
    EXPECT_GE(wide.fov.right_rad, view.fov.right_rad - 1e-9);
    EXPECT_EQ(eyes_[eye].traced.size, wide.size);
    EXPECT_EQ(eyes_[eye].shown_mask.size, view.size);
    EXPECT_LT(glm::length(view.stage_from_eye.translation - wide.stage_from_eye.translation), 0.01);
  }
}

TEST_F(ClientDump, ListsTheLightsInBitOrder) {
  const Scene scene = load_scene(kRoom).value();
  const SceneState state = state_at(scene, time_from_ns(described_["shown"]["scene_time_ns"]));
  ASSERT_EQ(described_["lights"].size(), state.light_set.lights.size());
  for (std::size_t i = 0; i < state.light_set.lights.size(); ++i) {
    const auto p = described_["lights"][i]["stage_position_m"].get<std::array<double, 3>>();
    EXPECT_EQ(glm::dvec3(p[0], p[1], p[2]), state.light_set.lights[i].position.v) << i;
  }
}

TEST_F(ClientDump, CoveredPixelsHaveFiniteDistanceAndBitsOfLightsOnly) {
  const std::uint32_t lights = static_cast<std::uint32_t>(described_["lights"].size());
  for (const DumpedEye& eye : eyes_) {
    std::size_t covered = 0;
    for (std::size_t i = 0; i < kClientSize.pixels(); ++i) {
      ASSERT_TRUE(std::isfinite(eye.distance.pixels[i]));
      ASSERT_GE(eye.distance.pixels[i], 0);
      ASSERT_LT(eye.traced.pixels[i], 1u << lights);
      ASSERT_LT(eye.shown_mask.pixels[i], 1u << lights);
      covered += eye.distance.pixels[i] > 0;
    }
    EXPECT_GT(covered, kClientSize.pixels() / 2);
    EXPECT_NE(*std::ranges::max_element(eye.traced.pixels), 0);
  }
}

/// Fails for swapped eyes, a mirrored picture, or a distance along the ray.
TEST_F(ClientDump, BothEyesSeeTheSameSurfaces) {
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    int common = 0, equal = 0;
    for_covered(eye, [&](std::uint32_t x, std::uint32_t y) {
      const auto other_pixel = pixel_in(shown_[1 - eye], shown_[eye], eyes_[eye].distance, x, y);
      if (!other_pixel) return;
      ++common;
      const double other = eyes_[1 - eye].distance.at(other_pixel->x, other_pixel->y);
      equal += std::abs(other - other_pixel->distance) < 0.03 * other_pixel->distance;
    });
    EXPECT_GT(common, static_cast<int>(kClientSize.pixels() / 3));
    EXPECT_GT(equal, common * 0.9) << "eye " << eye << ", of " << common;
  }
}

/// The share of covered pixels that show the bits of the traced pixel with the same surface.
struct ReprojectionCount {
  int common = 0, equal = 0, equal_in_place = 0;
};

ReprojectionCount reprojected(const DumpedEye& eye, const View& shown, const View& traced) {
  ReprojectionCount count;
  for (std::uint32_t y = 0; y < kClientSize.height; ++y)
    for (std::uint32_t x = 0; x < kClientSize.width; ++x) {
      if (eye.distance.at(x, y) <= 0) continue;
      const auto other_pixel = pixel_in(traced, shown, eye.distance, x, y);
      if (!other_pixel) continue;
      ++count.common;
      count.equal += eye.traced.at(other_pixel->x, other_pixel->y) == eye.shown_mask.at(x, y);
      count.equal_in_place += eye.traced.at(x, y) == eye.shown_mask.at(x, y);
    }
  return count;
}

/// The shown mask is the traced mask, reprojected with the stated views. At shadow edges, of which there are
/// many at this size, it is filtered between pixels.
TEST_F(ClientDump, ShownMaskIsTheReprojectedTracedMask) {
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const ReprojectionCount count = reprojected(eyes_[eye], shown_[eye], traced_[eye]);
    EXPECT_GT(count.equal, count.common * 0.95) << "eye " << eye << ", of " << count.common;
    EXPECT_GE(count.equal, count.equal_in_place) << "eye " << eye;
  }
}

TEST_F(PredictedClientDump, ShownMaskIsTheReprojectedTracedMask) {
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const ReprojectionCount count = reprojected(eyes_[eye], shown_[eye], traced_[eye]);
    EXPECT_GT(count.equal, count.common * 0.95) << "eye " << eye << ", of " << count.common;
    EXPECT_GT(count.equal, count.equal_in_place * 1.05)
        << "eye " << eye << ": the guard band is no part of it";
  }
}

TEST_F(ClientDump, ShownPictureIsCloseToItsReference) {
  for (const DumpedEye& eye : eyes_) {
    EXPECT_EQ(eye.shown.size, kClientSize);
    EXPECT_GT(psnr_db(eye.shown, eye.reference), 18);
    EXPECT_LT(psnr_db(eye.shown, eye.reference), 60) << "stale masks are never quite right";
  }
}

}  // namespace
}  // namespace farshade
