/// Descriptor: an open file. The destructor closes it.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <utility>

namespace farshade {

class Descriptor {
 public:
  Descriptor() = default;
  /// Takes the result of open(); -1 is no file.
  explicit Descriptor(int opened) : number_(opened) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() { close_now(); }

  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] bool is_open() const { return number_ >= 0; }

  /// Returns 0, or the errno of a late write error that only close() reports.
  int close_now() {
    const int closed = std::exchange(number_, -1);
    return closed < 0 || ::close(closed) == 0 ? 0 : errno;
  }

 private:
  int number_ = -1;
};

}  // namespace farshade
