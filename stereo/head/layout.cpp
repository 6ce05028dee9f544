#include "stereo/head/layout.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>

namespace farshade {
namespace {

/// Layouts that are read without column names.
struct Known {
  char separator;
  std::size_t columns;
  QuaternionOrder order;
  TimeUnit usual_unit;
};
constexpr Known kKnown[] = {
    {',', 8, QuaternionOrder::Wxyz,
     TimeUnit::Nanoseconds},  // EuRoC/ASL, VINS-Mono, Monado, Basalt, ADVIO (s)
    {',', 11, QuaternionOrder::Wxyz, TimeUnit::Nanoseconds},  // VINS-Fusion: with velocity
    {',', 17, QuaternionOrder::Wxyz, TimeUnit::Nanoseconds},  // EuRoC/ASL: with velocity and biases
    {' ', 8, QuaternionOrder::Xyzw, TimeUnit::Seconds}};      // TUM, evo, ORB-SLAM3 (EuRoC runs: ns), OKVIS

/// Layouts without column names that are refused by name.
struct Foreign {
  std::size_t columns;
  std::string_view what;
};
constexpr Foreign kForeign[] = {
    {6, "positions and Euler angles without time stamps"},
    {7, "positions and rotations without time stamps, or Euler angles"},
    {12, "KITTI poses: 3x4 matrices without time stamps"},
    {13, "time stamps and 3x4 matrices, as ARKit-Data-Logger writes"},
    {16, "4x4 matrices without time stamps, as Replica and ScanNet have"},
    {17, "time stamps and 4x4 matrices, as Structure SDK and HoloLens 2 research mode write"}};
constexpr std::string_view kCure = "; convert them to TUM: `timestamp tx ty tz qx qy qz qw`";

std::optional<double> value_of(std::string_view field) {
  double value = 0;
  const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  const bool is_number = error != std::errc::invalid_argument && stop == field.data() + field.size();
  return is_number ? std::optional(value) : std::nullopt;
}
bool is_number(std::string_view field) {
  return value_of(field).has_value();
}

/// "PositionX [m]" becomes position, x, m.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    const bool starts = std::isupper(c) && i > 0 && std::islower(static_cast<unsigned char>(name[i - 1]));
    if ((starts || !std::isalnum(c)) && !words.back().empty()) words.emplace_back();
    if (std::isalnum(c)) words.back() += static_cast<char>(std::tolower(c));
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

template <std::size_t N>
bool has(const std::vector<std::string>& words, const std::string_view (&any)[N]) {
  return std::ranges::any_of(words,
                             [&](const std::string& word) { return std::ranges::count(any, word) > 0; });
}

constexpr std::string_view kPosition[] = {"p",     "t",           "pos", "position",
                                          "trans", "translation", "loc", "location"};
constexpr std::string_view kRotation[] = {"q",          "o",   "rot",    "rotation",   "quat",
                                          "quaternion", "ori", "orient", "orientation"};
constexpr std::string_view kTime[] = {"timestamp", "timestamps", "time", "stamp",  "t",
                                      "ts",        "sec",        "secs", "seconds"};
constexpr std::string_view kSeconds[] = {"sec", "secs", "seconds"};
constexpr std::string_view kNanoseconds[] = {"nsec", "nsecs", "nanosec", "nanosecs"};
constexpr std::string_view kTracked[] = {"valid", "tracked", "istracked"};
constexpr std::string_view kAngles[] = {"roll", "pitch", "yaw", "euler"};
/// Columns of other things than the head.
constexpr std::string_view kOther[] = {"gaze",     "velocity",  "vel",  "left",       "right",
                                       "lefthand", "righthand", "hand", "controller", "covariance"};

/// Units of positions, as in "x [m]", and how many are a metre.
constexpr std::pair<std::string_view, double> kLengths[] = {
    {"m", 1},     {"meter", 1},         {"meters", 1},         {"metre", 1},         {"metres", 1},
    {"cm", 100},  {"centimeter", 100},  {"centimeters", 100},  {"centimetre", 100},  {"centimetres", 100},
    {"mm", 1000}, {"millimeter", 1000}, {"millimeters", 1000}, {"millimetre", 1000}, {"millimetres", 1000}};

std::optional<double> units_a_metre_of(std::string_view word) {
  const auto* const found = std::ranges::find(kLengths, word, [](const auto& unit) { return unit.first; });
  return found == std::end(kLengths) ? std::nullopt : std::optional(found->second);
}

/// Roles of coordinates without a word for position, in the order x, y, z.
constexpr std::string_view kBare = "123";

/// What a column holds: 'T' a time stamp, 'V' whether tracking is valid, "xyz" a coordinate of the position
/// (kBare: perhaps), "XYZW" one of the quaternion, 0 anything else. Sets `group` to the words without the
/// letter, which are equal for all coordinates of one vector.
char role_of(const std::vector<std::string>& words, std::string& group) {
  if (words.empty() || has(words, kOther)) return 0;
  enum class Kind : std::uint8_t { Unknown, Position, Rotation } kind = Kind::Unknown;
  char letter = 0;
  std::size_t letter_at = 0;
  for (const std::string& word : words) {
    const std::string_view start = std::string_view(word).substr(0, word.size() - 1);
    const bool ends = std::string_view("xyzw").find(word.back()) != std::string_view::npos;
    const auto is = [&](const auto& any) {  // the word, or with a letter, as tx, posx, qw
      return std::ranges::count(any, word) > 0 || (ends && std::ranges::count(any, start) > 0);
    };
    if (kind == Kind::Unknown && is(kPosition)) kind = Kind::Position;
    if (kind == Kind::Unknown && is(kRotation)) kind = Kind::Rotation;
    if (ends &&
        (start.empty() || std::ranges::count(kPosition, start) + std::ranges::count(kRotation, start) > 0)) {
      letter = word.back();  // the last one: in p_WS_W_x, W is a frame
      letter_at = group.size() + start.size();
    }
    group += word + ' ';
  }
  if (letter) group[letter_at] = '?';
  const bool is_bare = kind == Kind::Unknown && words.front().size() == 1 &&
                       (words.size() == 1 || (words.size() == 2 && units_a_metre_of(words[1])));
  if (letter && kind == Kind::Position) return letter;
  if (letter && letter != 'w' && is_bare) return kBare[static_cast<std::size_t>(letter - 'x')];
  if (letter && kind == Kind::Rotation) return static_cast<char>(std::toupper(letter));
  if (has(words, kTime)) return 'T';
  return has(words, kTracked) ? 'V' : '\0';
}

std::optional<TimeUnit> unit_named(const std::vector<std::string>& words) {
  constexpr std::pair<std::string_view, TimeUnit> kNames[] = {{"ns", TimeUnit::Nanoseconds},
                                                              {"nsec", TimeUnit::Nanoseconds},
                                                              {"nanoseconds", TimeUnit::Nanoseconds},
                                                              {"us", TimeUnit::Microseconds},
                                                              {"usec", TimeUnit::Microseconds},
                                                              {"microseconds", TimeUnit::Microseconds},
                                                              {"ms", TimeUnit::Milliseconds},
                                                              {"msec", TimeUnit::Milliseconds},
                                                              {"milliseconds", TimeUnit::Milliseconds},
                                                              {"s", TimeUnit::Seconds},
                                                              {"sec", TimeUnit::Seconds},
                                                              {"seconds", TimeUnit::Seconds}};
  const auto* const found =
      std::ranges::find(kNames, words.back(), [](const auto& name) { return name.first; });
  return found == std::end(kNames) ? std::nullopt : std::optional(found->second);
}

struct Names {
  std::string roles;  ///< one of each column
  std::vector<std::vector<std::string>> words;
  std::vector<std::string> groups;
};

bool has_roles(const Names& names, std::string_view roles) {
  return std::ranges::all_of(roles, [&](char role) { return names.roles.find(role) != std::string::npos; });
}

/// The first of adjacent columns with these roles that belong to one vector. npos: there are none.
std::size_t first_with(const Names& names, std::string_view roles) {
  for (std::size_t at = names.roles.find(roles); at != std::string::npos;
       at = names.roles.find(roles, at + 1))
    if (std::all_of(names.groups.begin() + static_cast<std::ptrdiff_t>(at),
                    names.groups.begin() + static_cast<std::ptrdiff_t>(at + roles.size()),
                    [&](const std::string& group) { return group == names.groups[at]; }))
      return at;
  return std::string::npos;
}

/// "[cm]", "(s)" or "[]".
bool is_unit_alone(std::string_view field, const std::vector<std::string>& words) {
  return (field.starts_with("[") || field.starts_with("(")) &&
         (words.empty() || (words.size() == 1 && (units_a_metre_of(words[0]) || unit_named(words))));
}

Names names_of(std::string_view line) {
  std::vector<std::string_view> fields;
  split_row(line, line.find(',') == line.npos ? ' ' : ',', fields);
  Names names;
  for (const std::string_view field : fields) {
    std::vector<std::string> words = words_of(field);
    if (is_unit_alone(field, words) && !names.words.empty()) {  // "x [m]" between blanks
      std::ranges::move(words, std::back_inserter(names.words.back()));
      names.groups.back().clear();
      names.roles.back() = role_of(names.words.back(), names.groups.back());
      continue;
    }
    names.words.push_back(std::move(words));
    names.groups.emplace_back();
    names.roles += role_of(names.words.back(), names.groups.back());
  }
  const bool has_position = has_roles(names, "xyz");
  for (char& role : names.roles)
    if (const std::size_t bare = kBare.find(role); bare != kBare.npos)
      role = has_position ? '\0' : "xyz"[bare];
  return names;
}

bool is_complete(const Names& names) {
  return has_roles(names, "TxyzXYZW");
}

/// Whether a comment seems to name as many columns as `row` has. Words of a sentence name no coordinate.
bool names_some_of(const Names& names, std::string_view comment, const std::vector<std::string_view>& row) {
  return names.words.size() == row.size() && has_roles(names, "T") &&
         (comment.find(',') != comment.npos || names.roles.find_first_of("xyzXYZW") != std::string::npos);
}

/// The layout that complete names tell.
Expected<Layout> layout_named(const Names& names, rows::Place place) {
  Layout layout{.is_named = true};
  const auto first = [&](std::string_view roles) { return first_with(names, roles); };
  layout.stamp = first("T");
  const bool in_ns = has(names.words[layout.stamp], kNanoseconds);
  for (std::size_t i = 0; i < names.words.size(); ++i)
    if (i != layout.stamp && (has(names.words[i], kNanoseconds) || (in_ns && has(names.words[i], kSeconds))))
      return rows::fail_at(place, Fault::Unsupported,
                           "time stamps are split into seconds and nanoseconds: join them in one column");
  layout.unit = unit_named(names.words[layout.stamp]);
  layout.position = first("xyz");
  if (layout.position != std::string::npos)
    layout.units_a_metre = units_a_metre_of(names.words[layout.position].back());
  const std::size_t wxyz = first("WXYZ"), xyzw = first("XYZW");
  layout.order = wxyz < xyzw ? QuaternionOrder::Wxyz : QuaternionOrder::Xyzw;
  layout.rotation = std::min(wxyz, xyzw);
  if (layout.position == std::string::npos || layout.rotation == std::string::npos)
    return rows::fail_at(
        place, Fault::Unsupported,
        "columns should have the order x,y,z of the position, and qw,qx,qy,qz or qx,qy,qz,qw");
  if (const std::size_t valid = first("V"); valid != std::string::npos) layout.tracked = valid;
  layout.columns =
      1 + std::max({layout.stamp, layout.position + 2, layout.rotation + 3, layout.tracked.value_or(0)});
  return layout;
}

tl::unexpected<Error> refuse_names(const Names& names, rows::Place place) {
  if (std::ranges::any_of(names.words, [](const auto& words) { return has(words, kAngles); }))
    return rows::fail_at(place, Fault::Unsupported, "rotations are Euler angles" + std::string(kCure));
  std::string missing;
  constexpr std::pair<char, std::string_view> kRoles[] = {{'T', "time stamps"}, {'x', "x"},  {'y', "y"},
                                                          {'z', "z"},           {'W', "qw"}, {'X', "qx"},
                                                          {'Y', "qy"},          {'Z', "qz"}};
  for (const auto& [role, name] : kRoles)
    if (names.roles.find(role) == std::string::npos) missing.append(missing.empty() ? "" : ", ").append(name);
  return rows::fail_at(place, Fault::Malformed,
                       "no number and no column names of a head recording: no column of " + missing);
}

/// The layout of rows without column names.
Expected<Layout> layout_counted(const std::vector<std::string_view>& fields, char separator,
                                rows::Place place) {
  const std::size_t count = fields.size();
  const bool is_matrix = count == 17 && value_of(fields[15]) == 0.0 && value_of(fields[16]) == 1.0;
  for (const Known& known : kKnown)
    if (known.separator == separator && known.columns == count && !is_matrix)
      return Layout{
          .separator = separator, .columns = count, .order = known.order, .usual_unit = known.usual_unit};
  for (const Foreign& foreign : kForeign)
    if (foreign.columns == count)
      return rows::fail_at(place, Fault::Unsupported,
                           "rows of " + std::to_string(count) +
                               " columns are no head recording, but perhaps " + std::string(foreign.what) +
                               std::string(kCure));
  return rows::fail_at(
      place, Fault::Malformed,
      "row has " + std::to_string(count) +
          " columns; without column names, 8, 11 or 17 with commas and 8 with blanks are known: "
          "name the columns in a first line, as `#timestamp,x,y,z,qw,qx,qy,qz`");
}

/// The layout that a comment with more names than the first row has columns leaves: it only introduces the
/// names, as `# format: timestamp tx ...`, or has units as further words. The names still tell the order of
/// the quaternion. A row that is merely cut off keeps the names.
Expected<Layout> layout_introduced(Expected<Layout> named, const std::vector<std::string_view>& row,
                                   char separator, rows::Place place) {
  Expected<Layout> counted = layout_counted(row, separator, place);
  if (counted && named) {
    counted->order = named->order;
    counted->units_a_metre = named->units_a_metre;
    counted->unit = named->unit;
  }
  return counted || !named || named->columns <= row.size() ? counted : named;
}

/// Refuses tables as spreadsheets write them in many languages.
Expected<void> check_separators(std::string_view line, rows::Place place) {
  if (line.find(';') != line.npos)
    return rows::fail_at(
        place, Fault::Unsupported,
        "the columns are separated by semicolons: separate them by commas, and write decimals "
        "with a point");
  std::vector<std::string_view> fields;
  rows::split(line, ' ', fields);
  const auto is_decimal = [](std::string_view field) {
    const std::size_t comma = field.find(',');
    return comma != field.npos && comma > 0 && comma + 1 < field.size() &&
           field.find(',', comma + 1) == field.npos;
  };
  if (fields.size() > 1 && std::ranges::all_of(fields, is_decimal))
    return rows::fail_at(place, Fault::Unsupported,
                         "decimals are written with a comma: write them with a point");
  return {};
}

}  // namespace

bool is_comment(std::string_view line) {
  return line.front() == '#' || line.front() == '%';
}

void split_row(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  rows::split(line, separator, fields);
  if (fields.size() > 1 && fields.back().empty()) fields.pop_back();
  for (std::string_view& field : fields)
    if (field.size() >= 2 && field.starts_with('"') && field.ends_with('"'))
      field = field.substr(1, field.size() - 2);
}

Expected<Layout> layout_of(std::string_view text, std::string_view file) {
  rows::Lines lines(text, file);
  Expected<Layout> named = Layout{};
  std::size_t names_in_comment = 0;
  std::pair<std::string_view, rows::Place> last_comment;
  for (std::string_view line; lines.next(line);) {
    if (is_comment(line)) {
      last_comment = {rows::trimmed(line.substr(1)), lines.place()};
      if (const Names names = names_of(last_comment.first); is_complete(names)) {
        named = layout_named(names, lines.place());
        names_in_comment = names.words.size();
      }
      continue;
    }
    if (const Expected<void> sound = check_separators(line, lines.place()); !sound)
      return tl::unexpected(sound.error());
    const char separator = line.find(',') == line.npos ? ' ' : ',';
    std::vector<std::string_view> fields;
    split_row(line, separator, fields);
    if (std::ranges::none_of(fields, is_number)) {
      const Names names = names_of(line);
      if (!is_complete(names)) return refuse_names(names, lines.place());
      named = layout_named(names, lines.place());
      if (named) named->header_line = lines.place().line;
    } else if (const std::size_t written = fields.size() + (line.back() == separator ? 1 : 0);
               names_in_comment > written) {
      named = layout_introduced(std::move(named), fields, separator, lines.place());
      if (named && !named->is_named) return named;
    }
    if (!named) return named;
    if (!named->is_named) {
      const Names names = names_of(last_comment.first);
      if (names_some_of(names, last_comment.first, fields)) return refuse_names(names, last_comment.second);
      return layout_counted(fields, separator, lines.place());
    }
    named->separator = separator;
    named->usual_unit = separator == ' ' ? TimeUnit::Seconds : TimeUnit::Nanoseconds;
    return named;
  }
  return named;
}

}  // namespace farshade
