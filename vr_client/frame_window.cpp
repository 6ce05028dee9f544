#include "vr_client/frame_window.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace farshade {
namespace {

constexpr Duration kTitleInterval = std::chrono::seconds(1);

double aspect_of(const View& view) {
  const FovTangents window = tangents_of(view.fov);
  return (window.right_tan - window.left_tan) / (window.up_tan - window.down_tan);
}

double distance_of(const StereoView& views) {
  return glm::length(views[1].stage_from_eye.translation - views[0].stage_from_eye.translation);
}

}  // namespace

FrameWindow::FrameWindow(Client& client, Window& window, Controls& controls, Recordings& recordings,
                         Extent eye)
    : client_(client),
      window_(window),
      controls_(controls),
      recordings_(recordings),
      eye_(eye),
      presenter_(std::in_place, client.device, window, client.renderer->shown()) {}

void FrameWindow::replace(const PerEye<Image<Rgb8>>& pictures) {
  for (const Side side : kSides) presenter_->upload(side, pictures[index_of(side)]);
  pictures_ = {Picture::LeftUpload, Picture::RightUpload};
}

Composition FrameWindow::compose(const FrameView& view) const {
  constexpr std::array layouts{StereoLayout::SideBySide, StereoLayout::CrossEyed, StereoLayout::Mono,
                               StereoLayout::Anaglyph, StereoLayout::SideBySide};
  const StereoView& views = view.shown.views;
  return {.layout = layouts[static_cast<std::size_t>(controls_.display)],
          .pictures = pictures_,
          .aspect = aspect_of(views[0]),
          .shared = shared_columns({views[0].fov, views[1].fov}, distance_of(views), eye_),
          .right_px = panel_width_px(controls_, window_.framebuffer_size(), window_.text_scale())};
}

std::optional<PixelFacts> FrameWindow::inspected(const FrameView& view,
                                                 const Composition& composition) const {
  if (!inspects_pixel(controls_) || view.settings.report == PixelReport::Off || view.as == ShownAs::Picture ||
      controls_.overlay == Overlay::GuardBand)
    return std::nullopt;
  const std::optional<PixelOfEye> under =
      pixel_at(composition, window_.framebuffer_size(), eye_, window_.cursor_px());
  if (!under) return std::nullopt;
  // The second picture of a difference belongs to the left eye, too.
  const bool left = under->eye == 0 || controls_.display == DisplayMode::Difference;
  return inspection_.pixel(view, left ? Side::Left : Side::Right, under->pixel);
}

Presenter::Outcome FrameWindow::show(const Composition& composition, const RunFacts& run,
                                     const std::optional<PixelFacts>& pixel) {
  const PanelFacts facts = facts_of(run, pixel);
  return presenter_->show(composition, [&] { draw_panel(controls_, facts); });
}

PanelFacts FrameWindow::facts_of(const RunFacts& run, const std::optional<PixelFacts>& pixel) const {
  return {.history = history_,
          .scene = client_.scene,
          .context = run.context,
          .device = client_.device.name,
          .server = server_state(run.mode),
          .note = run.note.empty() ? recordings_.note() : run.note,
          .pixel = pixel,
          .recording_head = recordings_.records_head(),
          .writing_capture = recordings_.writes_capture(),
          .recording_frames = recordings_.records_frames(),
          .window = window_.framebuffer_size(),
          .scale = window_.text_scale()};
}

std::string FrameWindow::server_state(Mode mode) const {
  if (!client_.link)
    return !client_.plan.server  ? "no light casts shadows: no server"
           : mode == Mode::Local ? "shadow maps: no server"
                                 : "this client traces: no server";
  std::string server = std::string(name_of(mode)) + ", server " + to_string(client_.server);
  const std::optional<Time> last_received = client_.link->last_received();
  if (!last_received) return server + " does not answer";
  const Duration silence = client_.clock.now() - *last_received;
  if (silence > kSilentAfter) return fmt::format("{} silent for {:.0f} s", server, seconds_of(silence));
  return server;
}

void FrameWindow::add(const FrameView& view, Mode mode) {
  history_.add(view, inspection_.errors(), client_.link.get(), client_.clock.now());
  update_title(mode, view.start_up);
}

void FrameWindow::update_title(Mode mode, bool waits) {
  const Time now = client_.clock.now();
  const bool same = titled_mode_ == mode && titled_waiting_ == waits;
  if (titled_ && same && now - *titled_ < kTitleInterval) return;
  titled_ = now;
  titled_mode_ = mode;
  titled_waiting_ = waits;
  const std::string state = waits && client_.link
                                ? "waiting for the first answer of " + to_string(client_.server)
                                : fmt::format("{:.0f} frames per second", history_.figures().frames_per_s);
  window_.set_title(fmt::format("{}: {}, {}, {}", kTitle, client_.scene.name, name_of(mode), state));
}

Remembered recalled() {
  Expected<Remembered> remembered = load_remembered(remembered_path());
  if (remembered) return *remembered;
  spdlog::warn("the remembered layout of the preview is ignored: {}", remembered.error().what);
  return {};
}

}  // namespace farshade
