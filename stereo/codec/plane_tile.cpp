#include "stereo/codec/plane_tile.h"

#include <algorithm>
#include <bit>

namespace farshade {
namespace {

constexpr std::uint32_t kSide = kTileSide_px;

constexpr std::uint32_t low_bits(std::uint32_t bits) {
  return bits == 0 ? 0 : ~0u >> (32 - bits);
}

/// Zigzag coding modulo 2^bits: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
std::uint32_t zigzag(std::uint32_t difference, std::uint32_t bits) {
  const std::uint32_t negative = difference >> (bits - 1) & 1;
  return (difference << 1 ^ (0 - negative)) & low_bits(bits);
}
std::uint32_t unzigzag(std::uint32_t residual) {
  return residual >> 1 ^ (0 - (residual & 1));
}

std::uint32_t gradient(const std::uint32_t* lane, std::uint32_t x, std::uint32_t y) {
  if (x > 0 && y > 0) return lane[-1] + lane[-int{kSide}] - lane[-int{kSide} - 1];
  const std::ptrdiff_t step = y == 0 ? -1 : -int{kSide};
  return x + y == 1 ? lane[step] : 2 * lane[step] - lane[2 * step];
}

std::uint32_t median(const std::uint32_t* lane, std::uint32_t x, std::uint32_t y) {
  if (x == 0 || y == 0) return lane[y == 0 ? -1 : -int{kSide}];
  const std::uint32_t left = lane[-1], up = lane[-int{kSide}], corner = lane[-int{kSide} - 1];
  const auto [low, high] = std::minmax(left, up);
  return corner >= high ? low : corner <= low ? high : left + up - corner;
}

template <Prediction How>
std::uint32_t predicted(const std::uint32_t* lane, std::uint32_t x, std::uint32_t y) {
  return How == Prediction::Gradient ? gradient(lane, x, y) : median(lane, x, y);
}

/// Calls act(i, x, y) for all pixels but the first, which has no prediction.
template <class Act>
void for_the_others(Act act) {
  for (std::uint32_t i = 1; i < kTilePixelCount; ++i) act(i, i % kSide, i / kSide);
}

/// The residuals of a lane.
struct Residuals {
  Prediction how;
  TileWords of{};                           ///< zigzag-coded; the first pixel's is 0
  std::array<std::uint32_t, kSide> rows{};  ///< OR of each row
  std::uint32_t width = 0;                  ///< bits of the largest residual
  std::size_t row_count = 0;                ///< non-empty rows of bit planes

  [[nodiscard]] std::size_t bytes() const { return 2 * (width + row_count); }
};

template <Prediction How>
Residuals residuals_of(const TileWords& lane, std::uint32_t bits) {
  Residuals residuals{.how = How};
  for_the_others([&](std::uint32_t i, std::uint32_t x, std::uint32_t y) {
    residuals.of[i] = zigzag((lane[i] - predicted<How>(&lane[i], x, y)) & low_bits(bits), bits);
  });
  std::uint32_t all = 0;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) residuals.rows[y] |= residuals.of[y * kSide + x];
    all |= residuals.rows[y];
    residuals.row_count += static_cast<std::size_t>(std::popcount(residuals.rows[y]));
  }
  residuals.width = static_cast<std::uint32_t>(std::bit_width(all));
  return residuals;
}

/// A coded lane's first byte: bits of the largest residual, and the prediction above them.
constexpr std::uint32_t kPredictionShift = 6;

void write_residuals(const Residuals& residuals, ByteWriter& io) {
  for (std::uint32_t bit = residuals.width; bit-- > 0;) {
    std::uint32_t holding = 0;
    for (std::uint32_t y = 0; y < kSide; ++y) holding |= (residuals.rows[y] >> bit & 1) << y;
    io.u16(holding);
    for (std::uint32_t y = 0; y < kSide; ++y) {
      if ((holding >> y & 1) == 0) continue;
      std::uint32_t row = 0;
      for (std::uint32_t x = 0; x < kSide; ++x) row |= (residuals.of[y * kSide + x] >> bit & 1) << x;
      io.u16(row);
    }
  }
}

void write_lane(const TileWords& lane, std::uint32_t bits, std::vector<std::byte>& out) {
  ByteWriter io(out);
  Residuals residuals = residuals_of<Prediction::Gradient>(lane, bits);
  if (residuals.width > 0)
    if (const Residuals other = residuals_of<Prediction::Median>(lane, bits);
        other.bytes() < residuals.bytes())
      residuals = other;
  io.u8(residuals.width | static_cast<std::uint32_t>(residuals.how) << kPredictionShift);
  for (std::uint32_t bit = 0; bit < bits; bit += 8) io.u8(lane[0] >> bit & 0xff);
  write_residuals(residuals, io);
}

/// A coded lane that was found to be complete.
struct WrittenLane {
  Prediction how;
  std::uint32_t width = 0, first = 0;
  ByteReader residuals;
};

/// Skips bit planes. False if they end early.
bool skip_residuals(ByteReader& in, std::uint32_t width) {
  for (; width > 0; --width) {
    std::uint32_t holding = 0, row = 0;
    if (!in.u16(holding)) return false;
    for (; holding != 0; holding &= holding - 1)
      if (!in.u16(row)) return false;
  }
  return true;
}

Decoded<WrittenLane> find_lane(ByteReader& in, std::uint32_t bits) {
  std::uint32_t coding = 0, first = 0;
  if (!in.u8(coding)) return refuse(WireRefusal::TileLength);
  const auto how = static_cast<Prediction>(coding >> kPredictionShift);
  const std::uint32_t width = coding & low_bits(kPredictionShift);
  if (how > Prediction::Median) return refuse(WireRefusal::TileCoding);
  if (width > bits) return refuse(WireRefusal::TileBits);
  for (std::uint32_t bit = 0; bit < bits; bit += 8) {
    std::uint32_t byte = 0;
    if (!in.u8(byte)) return refuse(WireRefusal::TileLength);
    first |= byte << bit;
  }
  WrittenLane lane{how, width, first, in};
  if (!skip_residuals(in, width)) return refuse(WireRefusal::TileLength);
  return lane;
}

void read_residuals(ByteReader in, std::uint32_t width, TileWords& residuals) {
  residuals.fill(0);
  for (std::uint32_t bit = width; bit-- > 0;) {
    std::uint32_t holding = 0;
    in.u16(holding);
    for (; holding != 0; holding &= holding - 1) {
      std::uint32_t row = 0;
      in.u16(row);
      std::uint32_t* const rest = &residuals[static_cast<std::size_t>(std::countr_zero(holding)) * kSide];
      for (std::uint32_t x = 0; x < kSide; ++x) rest[x] |= (row >> x & 1) << bit;
    }
  }
}

template <Prediction How>
void restore(const TileWords& residuals, std::uint32_t bits, TileWords& lane) {
  for_the_others([&](std::uint32_t i, std::uint32_t x, std::uint32_t y) {
    lane[i] = (predicted<How>(&lane[i], x, y) + unzigzag(residuals[i])) & low_bits(bits);
  });
}

void expand(const WrittenLane& written, std::uint32_t bits, TileWords& lane) {
  if (written.width == 0) return lane.fill(written.first);
  TileWords residuals;
  read_residuals(written.residuals, written.width, residuals);
  lane[0] = written.first;
  if (written.how == Prediction::Gradient)
    restore<Prediction::Gradient>(residuals, bits, lane);
  else
    restore<Prediction::Median>(residuals, bits, lane);
}

}  // namespace

void load_tile(const PixelPlane& plane, TileRect rect, TileWords& words) {
  for (std::uint32_t y = 0; y < kSide; ++y) {
    const std::uint32_t* const row =
        &plane.words[std::size_t{std::min(rect.y0 + y, rect.y1 - 1)} * plane.size.width + rect.x0];
    const std::uint32_t width = rect.x1 - rect.x0;
    for (std::uint32_t x = 0; x < kSide; ++x) words[y * kSide + x] = row[std::min(x, width - 1)];
  }
}

void store_tile(const TileWords& words, TileRect rect, PixelPlane& plane) {
  for (std::uint32_t y = rect.y0; y < rect.y1; ++y)
    std::copy_n(&words[std::size_t{y - rect.y0} * kSide], rect.x1 - rect.x0,
                &plane.words[std::size_t{y} * plane.size.width + rect.x0]);
}

void write_plane_tile(const TileWords& words, PlaneLanes lanes, std::vector<std::byte>& out) {
  for (std::uint32_t i = 0; i < lanes.count; ++i) {
    TileWords lane;
    std::ranges::transform(words, lane.begin(),
                           [&](std::uint32_t word) { return word >> i * lanes.bits & low_bits(lanes.bits); });
    write_lane(lane, lanes.bits, out);
  }
}

Decoded<void> read_plane_tile(ByteReader& in, PlaneLanes lanes, TileWords& words) {
  words.fill(0);
  for (std::uint32_t i = 0; i < lanes.count; ++i) {
    const Decoded<WrittenLane> written = find_lane(in, lanes.bits);
    if (!written) return refuse(written.error());
    TileWords lane;
    expand(*written, lanes.bits, lane);
    for (std::size_t pixel = 0; pixel < kTilePixelCount; ++pixel)
      words[pixel] |= lane[pixel] << i * lanes.bits;
  }
  return {};
}

Decoded<void> skip_plane_tile(ByteReader& in, PlaneLanes lanes) {
  for (std::uint32_t i = 0; i < lanes.count; ++i)
    if (const Decoded<WrittenLane> written = find_lane(in, lanes.bits); !written)
      return refuse(written.error());
  return {};
}

}  // namespace farshade
