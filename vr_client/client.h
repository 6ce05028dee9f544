/// Client: the objects that every run needs, in the order of their creation: scene, device, renderer,
/// reference tracer and the link to a server.
#pragma once

#include <future>
#include <memory>

#include "stereo/base/pausable_clock.h"
#include "stereo/base/stages.h"
#include "stereo/draw/renderer.h"
#include "stereo/gpu/device.h"
#include "stereo/link/network_link.h"
#include "stereo/net/impaired_port.h"
#include "vr_client/edge_ray_work.h"
#include "vr_client/frame/reference.h"
#include "vr_client/options.h"
#include "vr_client/record/capture_file.h"

namespace farshade {

/// Members are destroyed in reverse order.
struct Client {
  Scene scene;  ///< with the lights that the plan keeps
  ScenePlan plan;
  SceneLevels levels;  ///< empty: everything is drawn in full detail
  gpu::Device device;
  bool is_first_start = false;  ///< no start on this machine has kept its pipelines yet
  RendererLimits limits;
  std::unique_ptr<EdgeRayWork> edge_rays;  ///< once a renderer has needed it; later ones share its data
  std::unique_ptr<Renderer> renderer;      ///< with these limits
  std::unique_ptr<Reference> reference;    ///< for measuring; empty until open_reference
  std::unique_ptr<Reference> own_tracer;   ///< mode full: traces the shown shadows; empty until open_tracers
  PausableClock clock;  ///< of the link and the display; stands still while a preview holds a frame
  std::unique_ptr<DatagramPort> network;  ///< to the server
  ImpairedPort* simulator = nullptr;      ///< `network`, if it impairs the path: with --net, and in previews
  Peer server;
  std::unique_ptr<NetworkLink> link;   ///< in modes with a server, if a light casts shadows
  Duration round_trip{};               ///< measured during the handshake
  std::optional<Exposure> exposure{};  ///< of the server, or chosen here (settle_exposure)
};

/// The viewer of a preview can delay messages by at most this much.
inline constexpr double kWorstPreviewPath_ms = 400;

/// Number of requests that the client remembers: those whose masks have not arrived, and those whose masks
/// are still used.
[[nodiscard]] std::uint32_t requests_in_flight(const Options& options);

/// What a run with these options needs from the scene's plan.
[[nodiscard]] SessionNeeds needs_of(const Options& options, double eye_distance_m);

/// Sizes and counts for which the renderer of such a run allocates memory.
[[nodiscard]] RendererLimits renderer_limits(const Options& options);

/// Whether the client traces its own rays at shadow edges.
[[nodiscard]] bool has_edge_rays(const Options& options, const DrawPlan& plan);

/// Plans and makes the renderer anew for the mode of `options`, whose scene and device the client keeps. No
/// work on the device may be pending. Fails, with nothing changed, if the mode cannot be run here.
[[nodiscard]] Expected<void> reopen_renderer(const Options& options, Client& client, double eye_distance_m);

/// Replaces a device that is lost, which nothing uses any more, and makes the renderer anew with the same
/// limits. Fails, with the lost device kept, if none can be opened.
[[nodiscard]] Expected<void> reopen_device(const Options& options, Client& client);

/// The levels of detail of a scene, from the user's cache or newly made; none if the plan uses none.
[[nodiscard]] SceneLevels levels_for(const Scene& scene, const ScenePlan& plan);

/// The address for a value of --server. `auto` searches the local network and tells which server it found;
/// errors are those of find_server.
[[nodiscard]] Expected<std::string> server_address(const std::string& server);

/// The key for `server`. Missing if there is no key file, Unsupported if --insecure is for another machine.
[[nodiscard]] Expected<SharedKey> key_for(const Options& options, const Peer& server);

/// Loads the scene and makes its plan. Mismatch if a fetched scene is not the one that the server has.
[[nodiscard]] Expected<PlannedScene> load_planned(const Options& options, const SessionNeeds& needs);

/// Opens scene and device. Fails if the scene cannot be drawn.
[[nodiscard]] Expected<std::unique_ptr<Client>> open_client(const Options& options, const SessionNeeds& needs,
                                                            Stages& stages);

/// Creates the renderer, with the scene's levels of detail. The passes and the number of frames in flight are
/// those that the options or the device choose.
void open_renderer(const Options& options, Client& client, const RendererLimits& limits);

/// Creates the reference tracer unless it exists. It traces every ray. Fails if the scene cannot be
/// traced.
[[nodiscard]] Expected<void> open_reference(Client& client);

/// Creates the tracers that a run needs before its first frame: its own for mode full, which skips the same
/// rays as the server, and the reference if the options measure frames.
[[nodiscard]] Expected<void> open_tracers(const Options& options, Mode mode, Client& client);

/// Creates the renderer, then calls `compile`; and creates the tracers meanwhile.
[[nodiscard]] Expected<void> open_drawing(
    const Options& options, Mode mode, Client& client, const RendererLimits& limits, Stages& stages,
    const std::function<void()>& compile = [] {});

/// Opens the socket and a session with the server, if mode and scene need one. Of the addresses of a name,
/// the first that answers is used. A server that does not answer causes a warning, and the link keeps trying
/// its last address. A refusal by the server is an error. `listener` gets all messages from the first one on.
[[nodiscard]] Expected<void> open_link(const Options& options, Client& client,
                                       const LinkListener& listener = {});

/// Opens a new session on the same socket. The masks of the old session are dropped.
[[nodiscard]] Expected<void> connect(const Options& options, Client& client, LinkListener listener = {});

/// Keeps the session with the server while no frame is shown, and so nothing is requested.
class SessionKeeper {
 public:
  /// Call it several times a second. Reads what has arrived, and repeats the newest request once a second.
  void keep(Client& client);

 private:
  std::optional<Time> kept_alive_;  ///< on the machine's clock
};

/// Takes the exposure of the server. Without one, keeps an earlier one, or chooses it. Returns it.
Exposure settle_exposure(const Options& options, Client& client);

/// A run of this client in the mode of `options`, with its link. Settles the exposure. Keeps the references.
[[nodiscard]] RunContext context_of(const Options& options, Client& client, Runtime& runtime,
                                    const FrameSettings& settings);

/// The header of a capture of this client.
[[nodiscard]] CaptureHeader header_of(const Options& options, const Client& client);

/// Malformed, with the first message, if the validation layers reported anything.
[[nodiscard]] Expected<void> no_validation_messages(const gpu::Device& device);

}  // namespace farshade
