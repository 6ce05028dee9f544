#include "vr_client/preview/panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <numbers>

#include "vr_client/preview/inspection.h"
#include "vr_client/preview/layout.h"

namespace farshade {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

/// A slider over a double.
bool slide(const char* name, double& value, double low, double high, const char* format) {
  auto shown = static_cast<float>(value);
  if (!ImGui::SliderFloat(name, &shown, static_cast<float>(low), static_cast<float>(high), format,
                          ImGuiSliderFlags_AlwaysClamp))
    return false;
  value = std::clamp(static_cast<double>(shown), low, high);
  return true;
}

/// A check box that executes a command when it is clicked.
void box(const char* name, bool on, Command command, Controls& controls, const ControlContext& context) {
  if (ImGui::Checkbox(name, &on)) execute(command, controls, context);
}

void button(const char* name, Command command, Controls& controls, const ControlContext& context) {
  if (ImGui::Button(name)) execute(command, controls, context);
}

/// A list to choose one of `all` by name.
template <class All, class T>
void choose(const char* name, const All& all, T& chosen, const auto& name_of_one) {
  if (!ImGui::BeginCombo(name, std::string(name_of_one(chosen)).c_str())) return;
  for (const T& one : all)
    if (ImGui::Selectable(std::string(name_of_one(one)).c_str(), one == chosen)) chosen = one;
  ImGui::EndCombo();
}

/// Those of `all` that the controls offer.
template <class T, std::size_t count>
std::vector<T> offered(const std::array<T, count>& all, const Controls& controls) {
  std::vector<T> some;
  for (const T one : all)
    if (controls.offers(one)) some.push_back(one);
  return some;
}

void draw_legend(const Controls& controls, std::uint32_t lights) {
  for (const LegendEntry& entry : legend(controls.overlay, lights, controls.light)) {
    const float side = ImGui::GetTextLineHeight();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddRectFilled(corner, {corner.x + side, corner.y + side},
                                              IM_COL32(entry.color.r, entry.color.g, entry.color.b, 255));
    ImGui::Dummy({side, side});
    ImGui::SameLine();
    ImGui::TextWrapped("%s", entry.text.c_str());
  }
}

void draw_view(Controls& controls, const PanelFacts& facts) {
  choose("eyes", offered(kDisplayModes, controls), controls.display,
         [](DisplayMode display) { return name_of(display); });
  choose("overlay", offered(kOverlays, controls), controls.overlay,
         [](Overlay overlay) { return name_of(overlay); });
  if (shows_through(controls.overlay)) {
    double percent = controls.picture_share * 100;
    if (slide("picture", percent, 0, kMostPictureShare * 100, "%.0f %% through"))
      controls.picture_share = percent / 100;
  }
  draw_legend(controls, static_cast<std::uint32_t>(facts.scene.lights.size()));
  if (controls.offers(Command::Reference))
    box("reference: full trace, measure", controls.reference, Command::Reference, controls, facts.context);
}

void draw_path(Controls& controls) {
  slide("latency", controls.path.latency_ms, 0, kWorstPath.latency_ms, "%.0f ms");
  slide("jitter", controls.path.jitter_ms, 0, kWorstPath.jitter_ms, "%.0f ms");
  slide("loss", controls.path.loss_percent, 0, kWorstPath.loss_percent, "%.1f %%");
}

/// How often masks are requested, how wide, and how they are used.
void draw_requests(Controls& controls, const PanelFacts& facts) {
  auto every = static_cast<int>(controls.settings.request.every);
  if (ImGui::SliderInt("masks", &every, 0, static_cast<int>(kRarestMasks),
                       every == 0 ? "as often as needed" : "in 1 of %d frames", ImGuiSliderFlags_AlwaysClamp))
    controls.settings.request.every =
        static_cast<std::uint32_t>(std::clamp(every, 0, static_cast<int>(kRarestMasks)));
  auto band = static_cast<int>(controls.settings.request.guard_band_percent);
  if (ImGui::SliderInt("guard band", &band, 0, static_cast<int>(kWidestBand_percent), "%d %% of the measured",
                       ImGuiSliderFlags_AlwaysClamp))
    controls.settings.request.guard_band_percent =
        static_cast<std::uint32_t>(std::clamp(band, 0, static_cast<int>(kWidestBand_percent)));
  box("reprojection", controls.settings.reprojection.lookup == Lookup::Reproject, Command::Reprojection,
      controls, facts.context);
  ImGui::SameLine();
  box("band on", controls.settings.request.guard_band == GuardBandUse::Measured, Command::GuardBand, controls,
      facts.context);
}

void draw_masks(Controls& controls, const PanelFacts& facts) {
  if (controls.offers(Command::NextMode))
    choose("mode", controls.modes, controls.mode, [](Mode mode) { return name_of(mode); });
  if (controls.offers(Command::WorsePath)) draw_path(controls);
  if (controls.offers(Command::GuardBand)) {
    draw_requests(controls, facts);
    ImGui::SameLine();
  }
  box("ask whole", controls.settings.request.asks == Asks::Whole, Command::AskWhole, controls, facts.context);
  choose("predictor", kPredictorKinds, controls.settings.request.predictor,
         [](PredictorKind kind) { return to_string(kind); });
}

void draw_time(Controls& controls, const PanelFacts& facts) {
  button(controls.held ? "let the time run" : "hold the frame", Command::HoldFrame, controls, facts.context);
  ImGui::SameLine();
  button("next frame", Command::NextFrame, controls, facts.context);
}

void draw_lights(Controls& controls, const PanelFacts& facts) {
  const std::vector<Light>& lights = facts.context.lights.lights;
  const bool scrolls = lights.size() > 6;
  if (scrolls) ImGui::BeginChild("lights", {0, 6 * ImGui::GetFrameHeightWithSpacing()}, true);
  for (std::uint32_t i = 0; i < lights.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::RadioButton("##selected", controls.light == i)) controls.light = i;
    ImGui::SameLine();
    const std::uint32_t selected = controls.light;
    bool on = lights[i].on;
    const std::string& name = facts.scene.lights[i].name;
    if (ImGui::Checkbox(name.empty() ? fmt::format("light {}", i).c_str() : name.c_str(), &on)) {
      controls.light = i;
      execute(Command::LightOnOff, controls, facts.context);
      controls.light = selected;
    }
    ImGui::PopID();
  }
  if (scrolls) ImGui::EndChild();
  button(controls.grab ? "release" : "grab", Command::GrabLight, controls, facts.context);
  ImGui::SameLine();
  button("reset", Command::ResetLights, controls, facts.context);
  if (facts.scene.animation_length_s == 0) return;
  ImGui::SameLine();
  box("animation", controls.settings.scene == SceneClock::Running, Command::Animation, controls,
      facts.context);
}

void draw_player(Controls& controls, const PanelFacts& facts, Player& player) {
  box("follow the recording", controls.head == HeadSource::Recording, Command::HeadSource, controls,
      facts.context);
  ImGui::SameLine();
  button(player.playing() ? "pause" : "play", Command::PlayPause, controls, facts.context);
  ImGui::SameLine();
  box("loop", player.at_end() == AtEnd::Loop, Command::Loop, controls, facts.context);
  double at_s = seconds_of(player.position());
  if (slide("at", at_s, 0, seconds_of(player.length()), "%.2f s")) player.scrub(duration_from_ms(at_s * 1e3));
  double speed = player.speed();
  if (slide("speed", speed, Player::kSlowest, Player::kFastest, "%.2f")) player.set_speed(speed);
}

void draw_head(Controls& controls, const PanelFacts& facts) {
  if (facts.context.player)
    draw_player(controls, facts, *facts.context.player);
  else
    ImGui::TextUnformatted("drag the picture to look around; W A S D Q E move");
  double apart_mm = controls.eye_distance_m * 1e3;
  if (slide("eyes apart", apart_mm, 0, kWidestEyes_m * 1e3, "%.0f mm"))
    controls.eye_distance_m = apart_mm * 1e-3;
  double fov_deg =
      (controls.recorded_fov ? (*controls.recorded_fov)[0].up_rad - (*controls.recorded_fov)[0].down_rad
                             : controls.fov_rad) *
      kDegrees;
  if (slide("field of view", fov_deg, kNarrowestView_rad * kDegrees, kWidestView_rad * kDegrees,
            "%.0f deg")) {
    controls.recorded_fov.reset();
    controls.fov_rad = fov_deg / kDegrees;
  }
}

void draw_recording(Controls& controls, const PanelFacts& facts) {
  button("screenshot", Command::Screenshot, controls, facts.context);
  ImGui::SameLine();
  box("head", facts.recording_head, Command::RecordHead, controls, facts.context);
  if (!controls.offers(Command::RecordCapture)) return;
  ImGui::SameLine();
  box("capture", facts.writing_capture, Command::RecordCapture, controls, facts.context);
  ImGui::SameLine();
  box("frames", facts.recording_frames, Command::RecordFrames, controls, facts.context);
}

/// The widths of a table's columns from their texts. ImGui would know them only in its second frame.
void fix_column(const auto& texts) {
  float width = 0;
  for (const std::string& text : texts) width = std::max(width, ImGui::CalcTextSize(text.c_str()).x);
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed, width);
}

/// These keys in two columns.
void draw_keys(std::span<const KeyHelp> all) {
  const std::size_t rows = (all.size() + 1) / 2;
  for (std::size_t first = 0; first < all.size(); first += rows) {
    std::vector<std::string> keys, descriptions;
    for (const KeyHelp& help : all.subspan(first, std::min(rows, all.size() - first))) {
      keys.push_back(help.keys);
      descriptions.emplace_back(help.description);
    }
    fix_column(keys);
    fix_column(descriptions);
  }
  const auto cell = [](const char* text) {
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(text);
  };
  for (std::size_t row = 0; row < rows; ++row) {
    ImGui::TableNextRow();
    for (std::size_t i = row; i < all.size(); i += rows) {
      cell(all[i].keys.c_str());
      cell(all[i].description);
    }
  }
}

/// All keys, in a window that fits 1280 x 720 pixels. In a smaller window the list scrolls.
void draw_help(Controls& controls, const PanelFacts& facts) {
  const ImVec2 window(static_cast<float>(facts.window.width), static_cast<float>(facts.window.height));
  ImGui::SetNextWindowPos({window.x / 2, window.y / 2}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSizeConstraints({0, 0}, window);
  ImGui::SetNextWindowFocus();
  if (ImGui::Begin("keys", nullptr,
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                       ImGuiWindowFlags_HorizontalScrollbar) &&
      ImGui::BeginTable("keys", 4, ImGuiTableFlags_SizingFixedFit)) {
    draw_keys(key_help(controls));
    ImGui::EndTable();
  }
  ImGui::End();
  if (ImGui::IsMouseClicked(0)) controls.help = false;
}

void draw_pixel(const PanelFacts& facts) {
  if (!facts.pixel) {
    ImGui::TextWrapped(
        "Move the mouse over a picture. The client knows nothing about pixels that the server drew, and the "
        "overlay "
        "guard-band shows other directions.");
    return;
  }
  const std::vector<Fact> words = in_words(*facts.pixel, facts.scene, facts.context.lights);
  if (!ImGui::BeginTable("pixel", 2, ImGuiTableFlags_SizingFixedFit)) return;
  std::vector<std::string> names;
  for (const Fact& fact : words) names.push_back(fact.name);
  fix_column(names);
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch);
  for (const Fact& fact : words) {
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(fact.name.c_str());
    ImGui::TableNextColumn();
    ImGui::TextWrapped("%s", fact.value.c_str());
  }
  ImGui::EndTable();
}

void tab(const char* name, Tab which, Controls& controls, const auto& draw) {
  const bool wanted = controls.wanted_tab == which;
  if (!ImGui::BeginTabItem(name, nullptr, wanted ? ImGuiTabItemFlags_SetSelected : ImGuiTabItemFlags_None))
    return;
  if (!controls.wanted_tab) controls.tab = which;
  draw();
  ImGui::EndTabItem();
}

/// Tabs, so that each part of the panel fits a window of 720 rows.
void draw_tabs(Controls& controls, const PanelFacts& facts) {
  if (!ImGui::BeginTabBar("tabs")) return;
  tab("view", Tab::View, controls, [&] { draw_view(controls, facts); });
  tab("masks", Tab::Masks, controls, [&] { draw_masks(controls, facts); });
  tab("scene", Tab::Scene, controls, [&] {
    draw_lights(controls, facts);
    if (!controls.offers(Command::HeadSource)) return;
    ImGui::Separator();
    draw_head(controls, facts);
  });
  tab("record", Tab::Record, controls, [&] { draw_recording(controls, facts); });
  tab("pixel", Tab::Pixel, controls, [&] { draw_pixel(facts); });
  controls.wanted_tab.reset();
  ImGui::EndTabBar();
}

}  // namespace

std::uint32_t panel_width_px(const Controls& controls, Extent window, double scale) {
  if (!controls.panel) return 0;
  return std::min(static_cast<std::uint32_t>(kPanelWidth_px * scale), window.width / 2);
}

void draw_panel(Controls& controls, const PanelFacts& facts) {
  if (controls.help) draw_help(controls, facts);
  const auto width = static_cast<float>(panel_width_px(controls, facts.window, facts.scale));
  if (width == 0) return;
  ImGui::SetNextWindowPos({static_cast<float>(facts.window.width) - width, 0});
  ImGui::SetNextWindowSize({width, static_cast<float>(facts.window.height)});
  const auto flags = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                     ImGuiWindowFlags_NoBringToFrontOnFocus;
  if (ImGui::Begin("panel", nullptr, flags)) {
    ImGui::TextWrapped("%s", facts.server.c_str());
    if (!facts.note.empty()) ImGui::TextWrapped("%s", facts.note.c_str());
    ImGui::TextDisabled("F1: keys   Tab: hide the panel");
    if (controls.offers(Command::HoldFrame)) draw_time(controls, facts);
    ImGui::PushItemWidth(ImGui::GetContentRegionAvail().x * 0.62f);
    draw_figures(facts.history, controls);
    draw_tabs(controls, facts);
    ImGui::TextDisabled("%s", facts.device.c_str());
    ImGui::PopItemWidth();
  }
  ImGui::End();
}

}  // namespace farshade
