/// Client: what a session stands on, opened in the order in which it is needed: scene, device, renderer,
/// reference, and the link to a server.
#pragma once

#include <memory>

#include "stereo/draw/renderer.h"
#include "stereo/net/impaired_port.h"
#include "vr_client/frame/reference.h"
#include "vr_client/link/network_link.h"
#include "vr_client/options.h"
#include "vr_client/record/capture_file.h"

namespace farshade {

/// Built top to bottom, torn down in reverse.
struct Client {
  Scene scene;  ///< with the lights that its plan keeps
  ScenePlan plan;
  gpu::Device device;
  std::unique_ptr<Renderer> renderer;
  std::optional<Reference> reference;   ///< what pictures are measured against; made when first needed
  std::optional<Reference> own_tracer;  ///< mode full: what it shows; made when first needed
  SteadyClock clock;
  std::unique_ptr<ImpairedPort> network;  ///< to the server; as good as it is where nothing impairs it
  Peer server;
  std::optional<NetworkLink> link;  ///< mode hybrid, where there are lights
  Duration round_trip{};            ///< of the first exchange with the server
};

/// By how much the viewer of a preview may make the path worse and still get masks.
inline constexpr double kWorstPreviewPath_ms = 400;

/// Frames that may be needed after they were asked for: while masks are on their way, and as older masks.
[[nodiscard]] std::uint32_t frames_in_flight(const Options& options);

/// What a session with `options` asks of the scene's plan, for eyes that far apart.
[[nodiscard]] SessionNeeds needs_of(const Options& options, double eye_distance_m);

/// How large the renderer of such a session is.
[[nodiscard]] RendererLimits renderer_limits(const Options& options);

/// The scene with its plan.
[[nodiscard]] Expected<PlannedScene> load_planned(const Options& options, const SessionNeeds& needs);

/// Scene, device and renderer. Refuses what cannot be drawn.
[[nodiscard]] Expected<std::unique_ptr<Client>> open_client(const Options& options, double eye_distance_m);

/// The same for a session that is on file.
[[nodiscard]] Expected<std::unique_ptr<Client>> open_client(const Options& options, const SessionNeeds& needs,
                                                            const RendererLimits& limits);

/// Makes the reference, unless there is one. It traces every ray, without proofs. Refuses a scene that cannot
/// be traced.
[[nodiscard]] Expected<void> open_reference(Client& client);

/// Makes the tracer of mode full, unless there is one. It skips rays as the server does. Refuses a scene that
/// cannot be traced.
[[nodiscard]] Expected<void> open_own_tracer(Client& client);

/// Opens the network and begins a session with the server, if the mode and the scene need one. A server that
/// does not answer is a warning: the link goes on trying. A server that refuses us is an error.
/// `listener` is told what is said from the first word on.
[[nodiscard]] Expected<void> open_link(const Options& options, Client& client, LinkListener listener = {});

/// Begins another session over the network that is open: the old one's masks are gone.
[[nodiscard]] Expected<void> meet(const Options& options, Client& client, LinkListener listener = {});

/// What a recording of a session of this client says first.
[[nodiscard]] CaptureHeader header_of(const Options& options, const Client& client, const MaskPolicy& policy);

/// Malformed, with the first message, if the validation layers have said anything.
[[nodiscard]] Expected<void> no_validation_messages(const gpu::Device& device);

}  // namespace farshade
