/// Ledger: counts the bytes of device memory by use, now and at peak, and the number of allocations. Each
/// allocation holds a Charge, which removes its bytes from the ledger when the memory is freed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <numeric>
#include <string_view>

namespace farshade::gpu {

/// What an allocation is used for.
enum class Use : std::uint8_t {
  Vertices,  ///< vertex streams and indices
  Textures,
  Frame,    ///< data written every frame: uniforms, lights, instances
  GBuffer,  ///< base colours and surfaces
  Depth,    ///< of shown and of requested views
  Masks,    ///< and their bitmaps of received tiles
  Motion,   ///< earlier transforms of instances that move
  Lists,    ///< of pixels for the second shading pass
  Shown,    ///< the shaded picture
  Report,   ///< per pixel, how it was shaded
  ReadBack,
  ShadowMaps,  ///< of a client that draws its own shadows
  EdgeRays,    ///< light buffers and the triangles in them
  Staging,     ///< host memory from which the device copies
  Uploads,     ///< the same for what the host writes every frame
  Other,
};
inline constexpr std::size_t kUses = 16;

[[nodiscard]] std::string_view to_string(Use use);

struct BytesByUse {
  std::array<std::uint64_t, kUses> bytes{};

  [[nodiscard]] std::uint64_t& operator[](Use use) { return bytes[static_cast<std::size_t>(use)]; }
  [[nodiscard]] std::uint64_t operator[](Use use) const { return bytes[static_cast<std::size_t>(use)]; }
  [[nodiscard]] std::uint64_t total() const {
    return std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0});
  }
};

/// Allocated bytes, as rounded up by the driver.
struct MemoryUse {
  BytesByUse now;
  BytesByUse peak;                ///< of each use separately; the peaks may lie at different times
  std::uint64_t peak_total = 0;   ///< of device memory and Staging: without Uploads
  std::uint64_t allocations = 0;  ///< that exist now
};

/// The ledger of one device. Thread-safe.
class Ledger {
 public:
  void add(Use use, std::uint64_t bytes);
  void remove(Use use, std::uint64_t bytes);
  [[nodiscard]] MemoryUse read() const;

 private:
  mutable std::mutex mutex_;
  MemoryUse use_;
};

/// One allocation's entry in a ledger. The entry exists as long as the Charge.
class Charge {
 public:
  Charge() = default;
  Charge(std::shared_ptr<Ledger> ledger, Use use, std::uint64_t bytes);
  Charge(const Charge&) = delete;
  Charge& operator=(const Charge&) = delete;
  Charge(Charge&& other) noexcept = default;
  Charge& operator=(Charge&& other) noexcept;
  ~Charge() { end(); }

 private:
  void end();

  std::shared_ptr<Ledger> ledger_;  ///< null: no entry
  Use use_ = Use::Other;
  std::uint64_t bytes_ = 0;
};

}  // namespace farshade::gpu
