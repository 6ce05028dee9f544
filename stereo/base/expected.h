/// Errors as values, for foreign bytes, files and missing devices.
/// A broken invariant of this program fails a `check` (check.h). A failed Vulkan call throws.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace farshade {

/// Kinds of errors that come from outside of this program.
enum class Fault {
  Missing,      ///< a file, device or peer does not exist
  Unreadable,   ///< it exists but cannot be read or written
  Malformed,    ///< the bytes break their format
  OutOfRange,   ///< well-formed, but a value is outside its stated limits
  Unsupported,  ///< valid, but this program does not implement it
  Mismatch,     ///< two sides that should agree do not agree
  Unavailable,  ///< a resource is in use or exhausted
  Interrupted,  ///< the user has ended the program by a signal
};

/// `what` is one sentence for the user: where it happened, what is wrong and, if known, how to fix it.
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
