/// Renderer draws frames: the G-buffer, the depth of requested views, and the shaded picture with masks
/// reprojected. A frame is recorded in parts and goes to the device in one submission (docs/gpu.md). Only
/// `finish`, and functions that read, wait for the device.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "stereo/base/clock.h"
#include "stereo/draw/counters.h"
#include "stereo/edge_rays/edge_ray_data.h"
#include "stereo/frame/cube_mask.h"
#include "stereo/frame/hidden_area.h"
#include "stereo/frame/pixel_plane.h"
#include "stereo/frame/tiles.h"
#include "stereo/gpu/recording.h"
#include "stereo/image/image.h"
#include "stereo/lod/levels.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/raster/detail.h"
#include "stereo/reproject/reprojection.h"
#include "stereo/scene/scene_state.h"
#include "stereo/shadow_maps/shadow_map_settings.h"

namespace farshade::gpu {
struct Device;
struct Image;
}  // namespace farshade::gpu

namespace farshade {

/// Triangles that the passes of a frame submitted, for both eyes.
struct DrawnTriangles {
  std::uint64_t gbuffer = 0;  ///< of the shown views
  std::uint64_t depth = 0;    ///< of requested views that are not shown
  std::uint64_t maps = 0;     ///< of shadow maps that were drawn
};

struct DrawTimes {
  Duration gbuffer{}, depth{}, shade{};  ///< on the device; depth: requested views that are not shown
  Duration maps{};                       ///< shadow maps, on the device; 0 if they were not redrawn
  Duration request_reprojection{};       ///< reprojecting a mask to the requested views, on the device
  Duration timewarp{};                   ///< turning a picture made for other views, on the device
  /// Wall time of the calls that draw pictures, submit and finish: recording, uploads, submission, waits.
  Duration total{};
  DrawnTriangles triangles{};
  /// The times on the device are those of the frame so many frames before this one.
  std::uint32_t frames_ago = 0;

  [[nodiscard]] Duration on_device() const {
    return gbuffer + depth + shade + maps + request_reprojection + timewarp;
  }
};

/// What the G-buffer has of one pixel.
struct ShownSurface {
  struct Instance {
    std::uint32_t index = 0;  ///< in the scene
    std::uint32_t level = 0;  ///< of detail, when levels were last used; 0: the mesh itself
  };
  float distance_m = 0;              ///< along -z; 0: no surface, and the rest means nothing
  glm::vec3 normal{0.0f};            ///< for shading; unit, stage axes
  std::optional<Instance> instance;  ///< empty if the G-buffer keeps none, because none can move
};

/// Near / distance of each shown pixel (kNearPlane_m), 0 where there is no surface: two layers of 32-bit
/// depth, one an eye, whose upper left part has the size of an eye. Usage transfer source, layout
/// ShaderReadOnlyOptimal.
struct ShownDepth {
  const gpu::Image& image;
  std::uint32_t first_layer = 0;
};

/// A request for a pair of faces of the cube mask.
struct FaceRequest {
  const FrameMoment& request;
  std::size_t slot = 0;  ///< of its record, less than kCubeMaskSlots
};

struct ShownFrame {
  StereoView views;  ///< both of the renderer's size
  const SceneState& state;
  const FrameMoment* request = nullptr;  ///< this frame's request, if any; the depth of its views is kept
  std::span<const TracedMask> masks;     ///< first source first; skipped if its depth is not in the ring
  /// Masks of the cube's faces, one of each pair at most; skipped if its depth is not kept.
  std::span<const TracedMask> cube_mask{};
  Reprojection reprojection;
  PixelReport report = PixelReport::Off;
  /// Set: shadows come from shadow maps instead of `masks`. shadow_map_bytes must succeed for these settings.
  const ShadowMapSettings* shadow_maps = nullptr;
  std::size_t request_slot = 0;  ///< where the depth is kept: the slot of the request's record
  std::span<const FaceRequest>
      faces{};  ///< this frame's requests for pairs of the cube mask; their depth is kept, too
  Detail detail = Detail::Levels;
  /// What the lenses hide: pixels without a surface, whatever is there. Null: nothing. In the views of the
  /// request it is less (hidden_in_request).
  const PerEye<HiddenArea>* hidden = nullptr;
};

/// Sizes of pictures and masks, and the number of requests whose depth is kept.
struct RendererLimits {
  Extent size;                     ///< of a shown eye, pixels
  Extent traced_size;              ///< of a traced eye or of a picture to turn, at most
  std::uint32_t depth_frames = 8;  ///< requests whose depth is kept, at most
  /// Frames that exist at one time: the one that is recorded, and those before it that the device may still
  /// work on. With 1, `finish` waits for its own frame.
  std::uint32_t frames = 1;
};

/// An interface, so that its users need not know Vulkan. make_renderer makes it.
///
/// The functions that draw record a part of the frame. They return before the device has begun, and wait only
/// if the frame has a part of the same kind already. Their arguments need not outlive them.
class Renderer {
 public:
  virtual ~Renderer() = default;

  virtual void draw(const ShownFrame& frame) = 0;

  /// Steps that create and run every pipeline that frames with these settings can need, whatever masks they
  /// have: about one each, in any order. After them no frame waits for a compiler. They take seconds where
  /// the driver has no cache. Call them before the first frame; they refer to the renderer. `changes`: a
  /// viewer can move lights.
  [[nodiscard]] virtual std::vector<std::function<void()>> compile_steps(const Reprojection& reprojection,
                                                                         PixelReport report,
                                                                         Changes changes) = 0;

  /// Shades the last drawn frame again. Views and state are the same; masks and Reprojection may differ.
  virtual void shade_again(const ShownFrame& frame) = 0;

  /// Draws the depth of the views of `request`, keeps it for the request's masks, and reads it back: metres
  /// along -z, 0 for uncovered pixels, in full detail. Waits for the device. Reuses the memory of `into`.
  /// `slot` is that of the request's record. `hidden`: pixels of its views without a surface, whatever is
  /// there; null: none.
  virtual void keep_depth(const FrameMoment& request, std::size_t slot, PerEye<Image<float>>& into,
                          const PerEye<HiddenArea>* hidden = nullptr) = 0;

  /// Draws the depth of the views of `request`, keeps it for the request's masks, and reprojects `base` to
  /// these views; read_reprojected reads the result. A light that has moved or was switched since the base
  /// was traced is unknown everywhere. Without a base (null), everything is unknown that has a surface.
  /// Returns whether there is a result: if not, the depth of the base is gone, or the plan does not reproject
  /// masks, and nothing is drawn. `slot` is that of the request's record, `hidden` as in keep_depth.
  [[nodiscard]] virtual bool reproject_to_request(const FrameMoment& request, std::size_t slot,
                                                  const TracedMask* base,
                                                  const PerEye<HiddenArea>* hidden = nullptr) = 0;

  /// What reproject_to_request has found. Waits for it, but not for what was recorded after it. Reuses the
  /// memory of `into`.
  virtual void read_reprojected(RequestReprojection& into) = 0;

  /// Shades a G-buffer that another renderer drew for `frame.views`. Masks are read with Lookup::Direct, and
  /// no depth is kept. The same planes, masks and lights give the same picture.
  virtual void draw_received(const GBufferPlanes& planes, const ShownFrame& frame) = 0;

  /// Shows an sRGB picture that was made for `from`, turned to `shown`. The picture and `from` have one size,
  /// with no side larger than that of a traced view. Pixels outside of the picture (outside_share) are black.
  virtual void show_timewarped(const PerEye<Image<Rgb8>>& picture, const StereoView& from,
                               const StereoView& shown) = 0;

  /// Turns the shown picture, which was made for `from`.
  virtual void timewarp_shown(const StereoView& from, const StereoView& shown) = 0;

  /// Draws `frame` without shadows and without its masks, and adds `difference`, a difference_of for `from`,
  /// turned to the frame's views. Its size is free as in show_timewarped. Pixels outside of it have no
  /// shadows.
  virtual void draw_with_difference(const ShownFrame& frame, const PerEye<Image<Rgb8>>& difference,
                                    const StereoView& from) = 0;

  /// Records commands of the caller after what has been recorded, in the same submission: they copy what is
  /// shown. `record` is called at once.
  virtual void append(const gpu::Recording& record) = 0;

  /// Hands everything that was recorded to the device, in one submission. Does not wait.
  virtual void submit() = 0;

  /// Ends the frame: submits what is left, and waits until the device has finished the oldest frame, so that
  /// another one can begin. Returns the times of that frame on the device, and `total` and `triangles` of the
  /// one that ends.
  virtual DrawTimes finish() = 0;

  /// Forgets the times of what was recorded since the last `finish`, and waits for it.
  virtual void discard_times() = 0;

  /// Forgets the depth of all requests and all masks. Call this when frame ids start again.
  virtual void forget() = 0;

  /// The depth of the views, or faces, of this request is kept.
  [[nodiscard]] virtual bool has_depth(FrameId frame) const = 0;

  // Results of the last draw. Functions that read wait for all that was recorded.
  /// The shaded picture: one layer per eye, rgba8 UNORM, usage sampled, layout General.
  [[nodiscard]] virtual const gpu::Image& shown() const = 0;
  /// The depth of the surfaces that `draw` or `draw_received` has shown.
  [[nodiscard]] virtual ShownDepth shown_depth() const = 0;
  [[nodiscard]] virtual PerEye<Image<Rgb8>> read_shown() = 0;
  [[nodiscard]] virtual ShownReport report(Side side) = 0;
  /// The report of the pixels of `part`.
  [[nodiscard]] virtual ShownReport report(Side side, const TileRect& part) = 0;
  [[nodiscard]] virtual ShownSurface read_surface(Side side, glm::uvec2 pixel) = 0;
  /// Metres along -z, 0 for uncovered pixels.
  [[nodiscard]] virtual PerEye<Image<float>> read_distance() = 0;
  /// Reuses the memory of the planes.
  virtual void read_gbuffer(GBufferPlanes& into) = 0;

  [[nodiscard]] virtual DrawCounters counters() const = 0;
  /// Something in the scene can move, according to the plan.
  [[nodiscard]] virtual bool anything_moves() const = 0;
};

/// The passes that are faster on `device`. Lavapipe executes both sides of every branch, so it needs lists;
/// a GPU leaves out branches that no lane takes.
[[nodiscard]] ShadingPasses suited_passes(const gpu::Device& device);

/// Keeps the references except `levels`, which are those of the scene or empty. `plan` is a plan for
/// `scene`; the scene has only the lights that the plan keeps. If the plan has edge rays, `edge_rays` is what
/// they need; until it is there, shadow edges have the line. Throws when the device runs out of memory.
[[nodiscard]] std::unique_ptr<Renderer> make_renderer(const gpu::Device& device, const Scene& scene,
                                                      DrawPlan plan, const RendererLimits& limits,
                                                      const SceneLevels& levels = {},
                                                      FutureEdgeRayData edge_rays = {});
/// With a plan that keeps all lights of the scene and suits any client.
[[nodiscard]] std::unique_ptr<Renderer> make_renderer(const gpu::Device& device, const Scene& scene,
                                                      const RendererLimits& limits);

}  // namespace farshade
