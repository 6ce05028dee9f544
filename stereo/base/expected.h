/// Failure as a value, for foreign bytes, files and missing devices.
/// Broken invariants of our own are `check` (check.h); failed Vulkan calls throw and only `main` catches.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace farshade {

/// Closed set of what can go wrong outside of this program.
enum class Fault {
  Missing,      ///< a file, device or peer that is not there
  Unreadable,   ///< it is there and may not be read or written
  Malformed,    ///< bytes that break their format
  OutOfRange,   ///< well-formed, but a value is outside its stated limits
  Unsupported,  ///< valid, and asks for something this program does not do
  Mismatch,     ///< two sides that should agree do not
  Unavailable,  ///< a resource that is taken or exhausted
};

/// `what` is one sentence for the user: where it happened, what is wrong and, where known, the cure.
struct Error {
  Fault fault;
  std::string what;
};

template <class T>
using Expected = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> fail(Fault fault, std::string what) {
  return tl::unexpected<Error>(Error{fault, std::move(what)});
}

}  // namespace farshade
