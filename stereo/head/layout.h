/// Layout: which columns of a text file hold time stamps, positions and rotations. Column names tell it, as
/// SLAM systems, loggers and game engines write them in many spellings (`p_RS_R_x [m]`, `tx_world_device`,
/// `PositionX`, `field.pose.orientation.w`). Without names, the number of columns tells it.
#pragma once

#include "stereo/head/rows.h"
#include "stereo/head/stamps.h"

namespace farshade {

enum class QuaternionOrder : std::uint8_t { Wxyz, Xyzw };
[[nodiscard]] constexpr std::string_view to_string(QuaternionOrder order) {
  return order == QuaternionOrder::Wxyz ? "wxyz" : "xyzw";
}

struct Layout {
  char separator = ',';                               ///< ' ': runs of blanks
  std::size_t columns = 8;                            ///< that a row needs
  std::size_t stamp = 0, position = 1, rotation = 4;  ///< first columns
  QuaternionOrder order = QuaternionOrder::Wxyz;
  TimeUnit usual_unit = TimeUnit::Nanoseconds;  ///< of files with this layout
  std::optional<TimeUnit> unit{};               ///< that the name of the stamps' column states
  std::optional<double> units_a_metre{};        ///< that the names of the positions' columns state
  std::optional<std::size_t> tracked{};         ///< a column that is 0 or false where tracking was lost
  bool is_named = false;  ///< by column names. Rows may then have more columns; otherwise exactly `columns`
  std::size_t header_line = 0;  ///< the line with the column names if it is not a comment
};

/// Lines that begin with # or %.
[[nodiscard]] bool is_comment(std::string_view line);

/// Splits a row, and takes the quotes off its fields. An empty last field, which a separator at the end of
/// the line leaves, is omitted.
void split_row(std::string_view line, char separator, std::vector<std::string_view>& fields);

/// The layout of a text that has at least one row. Of an empty text: EuRoC's. Refuses, with the name of the
/// program or layout if it is known, and line: tables with semicolons or decimal commas, poses without
/// stamps, matrices, Euler angles, stamps in two columns, quaternions in another order than wxyz and xyzw,
/// a last comment that seems to name the columns but not all that are needed, and rows without column names
/// that have another number of columns than known layouts.
[[nodiscard]] Expected<Layout> layout_of(std::string_view text, std::string_view file);

}  // namespace farshade
