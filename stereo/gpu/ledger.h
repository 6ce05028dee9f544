/// Ledger: how many bytes of device memory were allocated for what, now and at the most. Every Buffer and
/// Image carries the charge for its allocation, which is taken back when it is freed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <numeric>
#include <string_view>

namespace farshade::gpu {

/// What memory is for.
enum class Use : std::uint8_t {
  Vertices,  ///< vertex streams and indices
  Textures,
  Frame,    ///< what is told anew every frame: uniforms, lights, instances
  GBuffer,  ///< base colours and surfaces
  Depth,    ///< of shown and of requested views
  Masks,    ///< and which of their tiles are known
  Motion,   ///< where things that move were
  Lists,    ///< of pixels that take a second look
  Shown,    ///< the picture
  Report,   ///< what each pixel was shown with
  ReadBack,
  ShadowMaps,  ///< of a client that draws its own shadows
  Staging,     ///< on its way to the device
  Other,
};
inline constexpr std::size_t kUses = 14;

[[nodiscard]] std::string_view to_string(Use use);

struct BytesByUse {
  std::array<std::uint64_t, kUses> bytes{};

  [[nodiscard]] std::uint64_t& operator[](Use use) { return bytes[static_cast<std::size_t>(use)]; }
  [[nodiscard]] std::uint64_t operator[](Use use) const { return bytes[static_cast<std::size_t>(use)]; }
  [[nodiscard]] std::uint64_t total() const {
    return std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0});
  }
};

/// Allocated bytes, as the driver rounded them.
struct MemoryUse {
  BytesByUse now;
  BytesByUse peak;  ///< of each use by itself
  std::uint64_t peak_total = 0;
};

/// Of one device. Safe to use from several threads.
class Ledger {
 public:
  void add(Use use, std::uint64_t bytes);
  void take_back(Use use, std::uint64_t bytes);
  [[nodiscard]] MemoryUse read() const;

 private:
  mutable std::mutex mutex_;
  MemoryUse use_;
};

/// An allocation's entry in a ledger, for as long as it lives.
class Charge {
 public:
  Charge() = default;
  Charge(std::shared_ptr<Ledger> ledger, Use use, std::uint64_t bytes);
  Charge(Charge&& other) noexcept = default;
  Charge& operator=(Charge&& other) noexcept;
  ~Charge() { end(); }

 private:
  void end();

  std::shared_ptr<Ledger> ledger_;  ///< null: charges nothing
  Use use_ = Use::Other;
  std::uint64_t bytes_ = 0;
};

}  // namespace farshade::gpu
