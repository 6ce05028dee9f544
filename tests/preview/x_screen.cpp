#include "tests/preview/x_screen.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XTest.h>
#include <poll.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "stereo/base/check.h"

namespace farshade {

struct XScreen::Connection {
  Display* display;
  ::Window root;
  std::filesystem::path manager_settings{};
};

namespace {

/// By default Xlib ends the program when a window disappears while it is read.
int ignore_error(Display* /*display*/, XErrorEvent* /*error*/) {
  return 0;
}

template <class Visit>
void visit_all(Display* display, ::Window window, const Visit& visit) {
  visit(window);
  ::Window root = 0, parent = 0, *children = nullptr;
  unsigned count = 0;
  if (!XQueryTree(display, window, &root, &parent, &children, &count)) return;
  for (unsigned i = 0; i < count; ++i) visit_all(display, children[i], visit);
  if (children) XFree(children);
}

bool is_viewable(Display* display, ::Window window) {
  XWindowAttributes attributes{};
  return XGetWindowAttributes(display, window, &attributes) && attributes.map_state == IsViewable;
}

void key(Display* display, const std::string& name, Bool down) {
  const KeySym symbol = XStringToKeysym(name.c_str());
  check(symbol != NoSymbol, "a key has an X name");
  XTestFakeKeyEvent(display, XKeysymToKeycode(display, symbol), down, CurrentTime);
  XSync(display, False);
}

void button(Display* display, unsigned number, Bool down) {
  XTestFakeButtonEvent(display, number, down, CurrentTime);
  XSync(display, False);
}

}  // namespace

XScreen::XScreen()
    : server_(std::make_unique<ChildProgram>(std::vector<std::string>{"/usr/bin/Xvfb", "-displayfd", "1",
                                                                      "-screen", "0", "1600x900x24",
                                                                      "-nolisten", "tcp", "-terminate"})) {
  const auto number = server_->line_after("");
  check(number.has_value(), "Xvfb says its display (Debian: xvfb)");
  name_ = ":" + *number;
  setenv("DISPLAY", name_.c_str(), 1);
  Display* const display = XOpenDisplay(name_.c_str());
  check(display != nullptr, "the X server answers");
  XSetErrorHandler(ignore_error);
  x_ = std::make_unique<Connection>(Connection{display, DefaultRootWindow(display)});
  XSelectInput(display, x_->root, SubstructureNotifyMask);
}

XScreen::~XScreen() {
  if (manager_) {
    manager_->send(SIGTERM);
    manager_->wait();
    std::filesystem::remove(x_->manager_settings);
  }
  XCloseDisplay(x_->display);
  server_->send(SIGTERM);
  server_->wait();
}

void XScreen::manage_windows() {
  x_->manager_settings = std::filesystem::temp_directory_path() / ("twmrc_" + std::to_string(server_->id()));
  std::ofstream(x_->manager_settings) << "RandomPlacement\nNoGrabServer\n";
  manager_ = std::make_unique<ChildProgram>(
      // twm needs the fonts of this locale; the font sets of others may be missing.
      std::vector<std::string>{"/usr/bin/env", "LC_ALL=C", "twm", "-display", name_, "-f",
                               x_->manager_settings.string()});
  // The window manager is running once it has claimed the redirection of window requests.
  check(wait_until([&] {
          XWindowAttributes root{};
          XGetWindowAttributes(x_->display, x_->root, &root);
          return (root.all_event_masks & SubstructureRedirectMask) != 0;
        }),
        "the window manager starts (Debian: twm)");
}

std::optional<XScreen::WindowId> XScreen::find(const std::string& title) {
  std::optional<WindowId> found;
  visit_all(x_->display, x_->root, [&](::Window window) {
    if (is_viewable(x_->display, window) && title_of(window).starts_with(title)) found = window;
  });
  return found;
}

std::optional<XScreen::WindowId> XScreen::wait_for(const std::string& title) {
  std::optional<WindowId> found;
  if (wait_until([&] { return (found = find(title)).has_value(); })) return found;
  return std::nullopt;
}

bool XScreen::wait_until(const std::function<bool()>& holds) {
  constexpr int now_and_then_ms = 10;
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    pollfd events{.fd = ConnectionNumber(x_->display), .events = POLLIN, .revents = 0};
    if (XPending(x_->display) == 0) ::poll(&events, 1, now_and_then_ms);
    while (XPending(x_->display) > 0) {
      XEvent event;
      XNextEvent(x_->display, &event);
    }
  }
  return true;
}

Extent XScreen::size_of(WindowId window) {
  XWindowAttributes attributes{};
  XGetWindowAttributes(x_->display, window, &attributes);
  return {static_cast<std::uint32_t>(attributes.width), static_cast<std::uint32_t>(attributes.height)};
}

std::string XScreen::title_of(WindowId window) {
  char* name = nullptr;
  if (!XFetchName(x_->display, window, &name) || !name) return {};
  std::string title = name;
  XFree(name);
  return title;
}

Image<Rgb8> XScreen::screenshot(WindowId window) {
  const Extent size = size_of(window);
  XImage* const image = XGetImage(x_->display, window, 0, 0, size.width, size.height, AllPlanes, ZPixmap);
  if (!image) return {};
  Image<Rgb8> result(size);
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x) {
      const unsigned long pixel = XGetPixel(image, static_cast<int>(x), static_cast<int>(y));
      result.at(x, y) = Rgb8(pixel >> 16 & 255, pixel >> 8 & 255, pixel & 255);
    }
  XDestroyImage(image);
  return result;
}

void XScreen::focus(WindowId window) {
  XSetInputFocus(x_->display, window, RevertToParent, CurrentTime);
  XSync(x_->display, False);
}

void XScreen::press(const std::string& name) {
  key(x_->display, name, True);
}

void XScreen::release(const std::string& name) {
  key(x_->display, name, False);
}

void XScreen::tap(const std::string& name) {
  press(name);
  release(name);
}

void XScreen::move_mouse(WindowId window, int x, int y) {
  int root_x = 0, root_y = 0;
  ::Window child = 0;
  XTranslateCoordinates(x_->display, window, x_->root, x, y, &root_x, &root_y, &child);
  XTestFakeMotionEvent(x_->display, DefaultScreen(x_->display), root_x, root_y, CurrentTime);
  XSync(x_->display, False);
}

void XScreen::press_button(unsigned number) {
  button(x_->display, number, True);
}

void XScreen::release_button(unsigned number) {
  button(x_->display, number, False);
}

void XScreen::resize(WindowId window, Extent size) {
  XMoveResizeWindow(x_->display, window, 0, 0, size.width, size.height);
  XSync(x_->display, False);
}

void XScreen::close(WindowId window) {
  XEvent event{};
  event.xclient.type = ClientMessage;
  event.xclient.window = window;
  event.xclient.message_type = XInternAtom(x_->display, "WM_PROTOCOLS", False);
  event.xclient.format = 32;
  event.xclient.data.l[0] = static_cast<long>(XInternAtom(x_->display, "WM_DELETE_WINDOW", False));
  XSendEvent(x_->display, window, False, NoEventMask, &event);
  XSync(x_->display, False);
}

void XScreen::iconify(WindowId window) {
  XIconifyWindow(x_->display, window, DefaultScreen(x_->display));
  XSync(x_->display, False);
}

void XScreen::restore(WindowId window) {
  XMapWindow(x_->display, window);
  XSync(x_->display, False);
}

void XScreen::cover() {
  XSetWindowAttributes attributes{};
  attributes.override_redirect = True;  // no window manager moves it
  const int screen = DefaultScreen(x_->display);
  const ::Window cover =
      XCreateWindow(x_->display, x_->root, 0, 0, static_cast<unsigned>(DisplayWidth(x_->display, screen)),
                    static_cast<unsigned>(DisplayHeight(x_->display, screen)), 0, CopyFromParent, InputOutput,
                    CopyFromParent, CWOverrideRedirect, &attributes);
  XMapRaised(x_->display, cover);
  XSync(x_->display, False);
}

}  // namespace farshade
