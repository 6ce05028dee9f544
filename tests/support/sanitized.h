/// kSanitized: the program was built with AddressSanitizer or ThreadSanitizer. Then everything takes ten
/// times as long, and freed memory stays resident, so heap sizes cannot be measured.
#pragma once

namespace farshade {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)  // GCC
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)  // clang
inline constexpr bool kSanitized = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace farshade
