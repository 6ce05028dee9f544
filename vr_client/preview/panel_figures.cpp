#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "vr_client/preview/panel.h"

namespace farshade {
namespace {

struct Stage {
  const char* name;
  Duration FrameBar::*time;
  ImU32 color;
};
// Colours of Okabe and Ito, which people with colour vision deficiency can distinguish ("Color universal
// design", 2008).
constexpr Stage kStages[] = {
    {"request", &FrameBar::request, IM_COL32(230, 159, 0, 255)},
    {"collect", &FrameBar::collect, IM_COL32(240, 228, 66, 255)},
    {"G-buffer", &FrameBar::gbuffer, IM_COL32(0, 114, 178, 255)},
    {"requested depth", &FrameBar::depth, IM_COL32(86, 180, 233, 255)},
    {"reproject, shade", &FrameBar::shade, IM_COL32(0, 158, 115, 255)},
    {"rest of draw", &FrameBar::other, IM_COL32(204, 121, 167, 255)},
    {"preview", &FrameBar::watch, IM_COL32(150, 150, 150, 255)},
};

Duration total(const FrameBar& bar) {
  Duration sum{};
  for (const Stage& stage : kStages) sum += bar.*stage.time;
  return sum;
}

void row(const char* name, const std::string& value) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(name);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(value.c_str());
}

template <class T>
std::string text_of(const std::optional<T>& value, fmt::format_string<const T&> format) {
  return value ? fmt::format(format, *value) : "-";
}

void error_rows(const PerEye<EyeErrors>& errors) {
  const auto both = [&](double EyeErrors::*figure, double factor, const char* unit) {
    return fmt::format("{:.2f} | {:.2f}{}", errors[0].*figure * factor, errors[1].*figure * factor, unit);
  };
  row("mask error", both(&EyeErrors::mask_error, 100, " %"));
  row("PSNR", both(&EyeErrors::psnr_db, 1, " dB"));
  row("from newest", both(&EyeErrors::newest, 100, " %"));
  row("other eye", both(&EyeErrors::other_eye, 100, " %"));
  row("older", both(&EyeErrors::older, 100, " %"));
  row("cube mask", both(&EyeErrors::cube_mask, 100, " %"));
  row("neighbours", both(&EyeErrors::neighbours, 100, " %"));
  row("own rays", both(&EyeErrors::own_rays, 100, " %"));
  row("unknown", both(&EyeErrors::unknown, 100, " %"));
}

void figure_rows(const Figures& figures, const Controls& controls) {
  row("frame",
      text_of(figures.frame_ms, "{:.1f} ms") +
          fmt::format(" + {:.1f}, {:.1f} per second", figures.watch_ms.value_or(0), figures.frames_per_s));
  row("masks",
      text_of(figures.staleness_ms, "{:.0f} ms stale") + text_of(figures.age_ms, ", asked {:.0f} ms ago"));
  row("round trip",
      text_of(figures.round_trip_ms, "{:.1f} ms") + text_of(figures.server_ms, ", server {:.1f}"));
  row("path",
      fmt::format("{:.2f} Mbit/s", figures.megabit_per_s) + text_of(figures.loss_percent, ", {:.1f} % lost"));
  row("triangles", fmt::format("{} + {} requested", figures.triangles.gbuffer, figures.triangles.depth) +
                       (figures.triangles.maps > 0 ? fmt::format(" + {} maps", figures.triangles.maps) : ""));
  std::string rays = "-";
  if (figures.rays) rays = fmt::format("{:.2f} M per frame", static_cast<double>(*figures.rays) * 1e-6);
  row("rays", rays);
  row("requested", fmt::format("{}x{}", figures.requested.width, figures.requested.height) +
                       text_of(figures.guard_band_percent, ", {:+.0f} % pixels"));
  if (figures.black_percent > 0)
    row("not reached", fmt::format("{:.1f} %: the head turned beyond the picture", figures.black_percent));
  if (figures.errors)
    error_rows(*figures.errors);
  else if (controls.reference)
    row("mask error", "not measured");
}

/// One bar of stacked stages per frame, the newest on the right. A horizontal line marks each 10 ms, or each
/// 100 ms if the scale is above 150 ms.
void graph(const std::deque<FrameBar>& bars) {
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 size(ImGui::GetContentRegionAvail().x, 6 * ImGui::GetTextLineHeight());
  ImDrawList& canvas = *ImGui::GetWindowDrawList();
  const ImVec2 end(corner.x + size.x, corner.y + size.y);
  canvas.AddRectFilled(corner, end, IM_COL32(20, 20, 20, 255));
  double highest_ms = 20;
  for (const FrameBar& bar : bars) highest_ms = std::max(highest_ms, ms_of(total(bar)));
  const auto height = [&](double ms) { return static_cast<float>(ms / highest_ms) * size.y; };
  const float width = size.x / static_cast<float>(kGraphFrames);
  float x = end.x - width * static_cast<float>(bars.size());
  for (const FrameBar& bar : bars) {
    float y = end.y;
    for (const Stage& stage : kStages) {
      const float top = y - height(ms_of(bar.*stage.time));
      canvas.AddRectFilled({x, top}, {x + std::max(width - 1, 1.0f), y}, stage.color);
      y = top;
    }
    x += width;
  }
  const double step_ms = highest_ms > 150 ? 100 : 10;
  for (double ms = step_ms; ms < highest_ms; ms += step_ms)
    canvas.AddLine({corner.x, end.y - height(ms)}, {end.x, end.y - height(ms)}, IM_COL32(255, 255, 255, 60));
  canvas.AddText(corner, IM_COL32_WHITE, fmt::format("{:.0f} ms", highest_ms).c_str());
  ImGui::Dummy(size);
}

void graph_legend() {
  float x = 0;
  for (const Stage& stage : kStages) {
    const float width = ImGui::CalcTextSize(stage.name).x + 1.5f * ImGui::GetTextLineHeight();
    if (x > 0 && x + width < ImGui::GetContentRegionAvail().x)
      ImGui::SameLine();
    else
      x = 0;
    x += width;
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(stage.color), "%s", stage.name);
  }
}

}  // namespace

void draw_figures(const History& history, const Controls& controls) {
  if (ImGui::BeginTable("figures", 2, ImGuiTableFlags_SizingFixedFit)) {
    // ImGui would know the widths of the texts only in its second frame.
    ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed, ImGui::CalcTextSize("from newest").x);
    ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch);
    figure_rows(history.figures(), controls);
    ImGui::EndTable();
  }
  graph(history.bars());
  graph_legend();
}

}  // namespace farshade
