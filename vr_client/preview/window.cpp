#include "vr_client/preview/window.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// The desktops that the environment names, e.g. "DISPLAY=:0". Empty if there is none. GLFW 3.4 does not name
/// them.
std::string named_desktops() {
  std::string names;
  for (const std::string variable : {"WAYLAND_DISPLAY", "DISPLAY"}) {
    const char* const value = std::getenv(variable.c_str());
    if (value != nullptr && *value != '\0') names += (names.empty() ? "" : ", ") + variable + "=" + value;
  }
  return names;
}

/// GLFW's description of the last error.
std::string last_error() {
  const char* words = nullptr;
  glfwGetError(&words);
  return words ? words : "no reason given";
}

/// The key of `code` if it is one of the `count` codes from `first` on.
std::optional<Key> in_row(int code, int first, int count, Key first_key) {
  if (code < first || code >= first + count) return std::nullopt;
  return static_cast<Key>(static_cast<int>(first_key) + code - first);
}

/// Keys that are not in a row of consecutive codes.
constexpr std::pair<int, Key> kOtherKeys[] = {{GLFW_KEY_SPACE, Key::Space},
                                              {GLFW_KEY_TAB, Key::Tab},
                                              {GLFW_KEY_ENTER, Key::Enter},
                                              {GLFW_KEY_KP_ENTER, Key::Enter},
                                              {GLFW_KEY_ESCAPE, Key::Escape},
                                              {GLFW_KEY_LEFT, Key::Left},
                                              {GLFW_KEY_RIGHT, Key::Right},
                                              {GLFW_KEY_UP, Key::Up},
                                              {GLFW_KEY_DOWN, Key::Down},
                                              {GLFW_KEY_HOME, Key::Home},
                                              {GLFW_KEY_END, Key::End},
                                              {GLFW_KEY_EQUAL, Key::Plus},
                                              {GLFW_KEY_KP_ADD, Key::Plus},
                                              {GLFW_KEY_MINUS, Key::Minus},
                                              {GLFW_KEY_KP_SUBTRACT, Key::Minus},
                                              {GLFW_KEY_LEFT_BRACKET, Key::LeftBracket},
                                              {GLFW_KEY_RIGHT_BRACKET, Key::RightBracket},
                                              {GLFW_KEY_COMMA, Key::Comma},
                                              {GLFW_KEY_PERIOD, Key::Period},
                                              {GLFW_KEY_LEFT_SHIFT, Key::Shift},
                                              {GLFW_KEY_RIGHT_SHIFT, Key::Shift},
                                              {GLFW_KEY_LEFT_CONTROL, Key::Control},
                                              {GLFW_KEY_RIGHT_CONTROL, Key::Control}};

std::optional<Key> other_key(int code) {
  const auto* const found = std::ranges::find(kOtherKeys, code, &std::pair<int, Key>::first);
  return found == std::end(kOtherKeys) ? std::nullopt : std::optional(found->second);
}

std::optional<Key> key_of(int code) {
  if (const auto key = in_row(code, GLFW_KEY_A, 26, Key::A)) return key;
  if (const auto key = in_row(code, GLFW_KEY_0, 10, Key::Digit0)) return key;
  if (const auto key = in_row(code, GLFW_KEY_F1, 12, Key::F1)) return key;
  return other_key(code);
}

/// Where a window goes, in the screen coordinates of GLFW, whose unit may be several pixels.
struct Place {
  int left = 0, top = 0;
  double px_per_unit = 1;
  Desktop desktop;
};

double content_scale_of(GLFWwindow* window) {
  float x = 1, y = 1;
  glfwGetWindowContentScale(window, &x, &y);
  return static_cast<double>(y);
}

/// The place for a hidden window on the primary monitor. Its frame is outside of its size.
Place place_for(GLFWwindow* window) {
  int left = 0, top = 0, right = 0, bottom = 0, x = 0, y = 0, width = 0, height = 0, wide = 0, high = 0;
  glfwGetWindowFrameSize(window, &left, &top, &right, &bottom);
  if (GLFWmonitor* const monitor = glfwGetPrimaryMonitor())
    glfwGetMonitorWorkarea(monitor, &x, &y, &width, &height);
  int pixels_wide = 0, pixels_high = 0;
  glfwGetWindowSize(window, &wide, &high);
  glfwGetFramebufferSize(window, &pixels_wide, &pixels_high);
  Place place{.left = x + left, .top = y + top, .desktop = {}};
  if (wide > 0 && pixels_wide > 0) place.px_per_unit = static_cast<double>(pixels_wide) / wide;
  const auto room = [&](int outer, int frame, std::uint32_t unknown) {
    const double inner = (outer - frame) * place.px_per_unit;
    return inner > 0 ? static_cast<std::uint32_t>(inner) : unknown;
  };
  place.desktop = {.room = {room(width, left + right, kUnscaledWindow.width),
                            room(height, top + bottom, kUnscaledWindow.height)},
                   .content_scale = content_scale_of(window)};
  return place;
}

/// Gives a hidden window its size, in the middle of the work area, and shows it.
void place_and_show(GLFWwindow* window, const SizeOnDesktop& size) {
  const Place place = place_for(window);
  const Extent wanted = size(place.desktop);
  const auto units = [&](std::uint32_t px) { return static_cast<int>(std::lround(px / place.px_per_unit)); };
  const auto margin = [&](std::uint32_t room, std::uint32_t used) {
    return room > used ? units((room - used) / 2) : 0;
  };
  glfwSetWindowSize(window, std::max(units(wanted.width), 1), std::max(units(wanted.height), 1));
  glfwSetWindowPos(window, place.left + margin(place.desktop.room.width, wanted.width),
                   place.top + margin(place.desktop.room.height, wanted.height));
  glfwShowWindow(window);
}

Window& owner_of(GLFWwindow* window) {
  return *static_cast<Window*>(glfwGetWindowUserPointer(window));
}

}  // namespace

Expected<std::unique_ptr<Window>> open_window(const std::string& title, const SizeOnDesktop& size,
                                              const std::string& cure) {
  const std::string desktops = named_desktops();
  if (desktops.empty())
    return fail(Fault::Missing, std::string("cannot open a window: there is no desktop (neither DISPLAY nor "
                                            "WAYLAND_DISPLAY is set); ") +
                                    cure);
  const std::string cannot = "cannot open a window on the desktop (" + desktops + "): ";
  if (!glfwInit()) return fail(Fault::Missing, cannot + last_error() + "; " + cure);
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
  GLFWwindow* const window =
      glfwCreateWindow(narrow<int>(kSmallestWindow.width), narrow<int>(kSmallestWindow.height), title.c_str(),
                       nullptr, nullptr);
  if (!window) {
    const std::string words = last_error();
    glfwTerminate();
    return fail(Fault::Missing, cannot + words + "; " + cure);
  }
  place_and_show(window, size);
  return std::unique_ptr<Window>(new Window(window));
}

Window::Window(GLFWwindow* window) : window_(window) {
  glfwSetWindowUserPointer(window, this);
  glfwGetCursorPos(window, &cursor_.x, &cursor_.y);
  glfwSetKeyCallback(window, [](GLFWwindow* from, int key, int /*scancode*/, int action, int /*modifiers*/) {
    owner_of(from).on_key(key, action);
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* from, int button, int action, int /*modifiers*/) {
    owner_of(from).on_mouse_button(button, action);
  });
  glfwSetCursorPosCallback(window, [](GLFWwindow* from, double x, double y) {
    owner_of(from).on_cursor({x, y});
  });
  glfwSetScrollCallback(window,
                        [](GLFWwindow* from, double /*x*/, double y) { owner_of(from).on_scroll(y); });
}

Window::~Window() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

gpu::Presentation Window::presentation() const {
  std::uint32_t count = 0;
  const char** names = glfwGetRequiredInstanceExtensions(&count);
  return {.instance_extensions = std::vector<std::string>(names, names + count),
          .can_present = [](vk::Instance instance, vk::PhysicalDevice physical, std::uint32_t family) {
            return glfwGetPhysicalDevicePresentationSupport(instance, physical, family) == GLFW_TRUE;
          }};
}

vk::raii::SurfaceKHR Window::make_surface(const vk::raii::Instance& instance) const {
  VkSurfaceKHR surface = VK_NULL_HANDLE;
  if (glfwCreateWindowSurface(*instance, window_, nullptr, &surface) != VK_SUCCESS)
    throw std::runtime_error("glfwCreateWindowSurface: " + last_error());
  return {instance, surface};
}

Extent Window::framebuffer_size() const {
  if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED)) return {};
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  return {narrow<std::uint32_t>(width), narrow<std::uint32_t>(height)};
}

double Window::text_scale() const {
  return farshade::text_scale(framebuffer_size(), content_scale_of(window_));
}

/// GLFW reports the position in screen coordinates.
glm::dvec2 Window::cursor_px() const {
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  const Extent pixels = framebuffer_size();
  return cursor_ * glm::dvec2(pixels.width, pixels.height) /
         glm::dvec2(std::max(width, 1), std::max(height, 1));
}

bool Window::should_close() const {
  return glfwWindowShouldClose(window_);
}

void Window::set_title(const std::string& title) {
  glfwSetWindowTitle(window_, title.c_str());
}

Input Window::poll() {
  glfwPollEvents();
  Input input = input_;
  input_ = {.pressed = {}, .held = input_.held};
  return input;
}

void Window::wait(Duration longest) {
  glfwWaitEventsTimeout(seconds_of(longest));
}

void Window::attach_panel(std::function<bool(glm::dvec2)> covers) {
  check(panel_ == Panel::None, "only one panel is attached");
  ImGui_ImplGlfw_InitForVulkan(window_, true);  // ImGui passes all events on to the callbacks of this window
  panel_ = Panel::Attached;
  panel_covers_ = std::move(covers);
}

void Window::detach_panel() {
  ImGui_ImplGlfw_Shutdown();
  panel_ = Panel::None;
}

void Window::begin_panel() {
  ImGui_ImplGlfw_NewFrame();
  // The back end uses screen coordinates, whose unit is larger than a pixel on some desktops.
  const Extent size = framebuffer_size();
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(size.width), static_cast<float>(size.height)};
  io.DisplayFramebufferScale = {1, 1};
  const glm::dvec2 mouse = cursor_px();
  if (io.MousePos.x > -FLT_MAX) io.MousePos = {static_cast<float>(mouse.x), static_cast<float>(mouse.y)};
}

/// Releases are always handled, so that a key that was down when the panel took the keyboard is not stuck.
void Window::on_key(int key, int action) {
  const auto known = key_of(key);
  if (!known) return;
  const auto number = static_cast<std::size_t>(*known);
  if (action == GLFW_RELEASE) input_.held[number] = false;
  if (action != GLFW_PRESS || (panel_ == Panel::Attached && ImGui::GetIO().WantTextInput)) return;
  input_.held[number] = true;
  input_.pressed.push_back(*known);
}

void Window::on_mouse_button(int button, int action) {
  if (button != GLFW_MOUSE_BUTTON_LEFT) return;
  const bool panels = panel_ == Panel::Attached && panel_covers_(cursor_px());
  mouse_ = action == GLFW_PRESS && !panels ? Mouse::Dragging : Mouse::Free;
}

void Window::on_cursor(glm::dvec2 position) {
  if (mouse_ == Mouse::Dragging) input_.drag_px += position - cursor_;
  cursor_ = position;
}

void Window::on_scroll(double notches) {
  if (panel_ == Panel::None || !panel_covers_(cursor_px())) input_.scroll += notches;
}

}  // namespace farshade
