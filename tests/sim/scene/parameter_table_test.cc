// The table of parameters: complete, in the order of its kinds, and what pages and programs say of units.
#include "sim/scene/parameter_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/parameters.h"

namespace clothid::parameter_table_test {
namespace {

// Every axis of a row, of the first of its parts where there is none of the whole.
std::vector<ParameterId> AxesOf(const ParameterRow& row) {
  std::vector<ParameterId> ids;
  for (int axis = 0; axis < std::max(1, row.num_axes); ++axis) {
    ids.push_back({row.kind, axis, row.has_whole ? kWhole : 0});
  }
  return ids;
}

std::string Source(const std::string& path) { return ReadText(CLOTHID_SOURCE_DIR "/" + path, 1 << 20); }

TEST(ParameterTableTest, HasARowForEveryKindInTheirOrder) {
  const std::vector<ParameterRow>& table = ParameterTable();
  ASSERT_EQ(table.size(), static_cast<std::size_t>(ParameterKind::kForceBias) + 1);
  std::set<std::string> names;
  for (std::size_t i = 0; i < table.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(table[i].kind), i) << table[i].name;
    EXPECT_TRUE(names.insert(table[i].name).second) << table[i].name;
  }
}

TEST(ParameterTableTest, HoldsEveryConstantOfAMaterial) {
  EXPECT_EQ(sizeof(Material), MaterialKinds().size() * sizeof(double));
  Material material;
  for (const ParameterKind kind : MaterialKinds()) {
    Material other = material;
    other.*RowOf(kind).constant += 1.0;
    EXPECT_FALSE(other == material) << RowOf(kind).name;
  }
}

// Each scalar has a place of its own: what is set comes back, and nothing else has changed.
TEST(ParameterTableTest, EveryRowHasAPlaceOfItsOwn) {
  Parameters parameters;
  parameters.friction_coefficients = {0.3};
  parameters.placements.resize(1);
  std::vector<ParameterId> ids;
  for (const ParameterRow& row : ParameterTable()) {
    for (const ParameterId id : AxesOf(row)) {
      if (!IsOfRecording(row.kind)) ids.push_back(id);
    }
  }
  for (std::size_t i = 0; i < ids.size(); ++i) SetParameter(ids[i], static_cast<double>(i + 1), &parameters);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_EQ(GetParameter(parameters, ids[i]), static_cast<double>(i + 1)) << RowOf(ids[i].kind).name;
  }
  EXPECT_THROW(GetParameter(parameters, {ParameterKind::kShift, 1}), std::logic_error);
  EXPECT_THROW(SetParameter({ParameterKind::kShift, 1}, 1.0, &parameters), std::logic_error);
}

// Whatever there is has one name, which reads back; but for a recording's, `ParseParameter` reads it, too.
TEST(ParameterTableTest, EveryNameReadsBack) {
  const std::vector<std::string> obstacles = {"wind", "ball"}, pieces = {"x", "hem"};
  std::set<std::string> names;
  for (const ParameterRow& row : ParameterTable()) {
    for (const ParameterId first : AxesOf(row)) {
      const int num_parts = row.part == ParameterPart::kNone ? 0 : 2;
      for (int part = first.part; part < num_parts; ++part) {
        const ParameterId id = {row.kind, first.axis, part};
        const std::string name = ParameterName(id, obstacles, pieces);
        EXPECT_TRUE(names.insert(name).second) << name;
        EXPECT_EQ(FindParameter(name, obstacles, pieces), id) << name;
        if (IsOfRecording(row.kind)) {
          EXPECT_THROW(ParseParameter(name, obstacles, pieces), Error) << name;
        } else {
          EXPECT_EQ(ParseParameter(name, obstacles, pieces), id) << name;
        }
      }
    }
  }
  for (const char* name :
       {"wind", "wind.w", "wind.x.0", "wind.x.01", "wind.x.", "gust.x.1", "size.z", "shift.x.1", "mu.", "ball.shift",
        "ball.shift.x.1", "cup.shift.x", ".shift.x", "k_stretch.cup", "drag_normal.x"}) {
    EXPECT_FALSE(FindParameter(name, obstacles, pieces)) << name;
  }
}

// costs/README.md lists every name, with its unit in the same row.
TEST(ParameterTableTest, PageOfCostsTellsEveryUnit) {
  const std::string page = Source("costs/README.md");
  for (const ParameterRow& row : ParameterTable()) {
    if (row.term == ParameterTerm::kPlacement) continue;  // in the page of scenes
    const std::string name =
        ParameterName(AxesOf(row).front(), {});  // the others stand behind it: "`wind.x`, `.y`, `.z`"
    const std::string unit = std::string(row.unit).empty() ? "1" : row.unit;
    bool is_told = false;
    for (const std::string& line : Split(page, '\n')) {
      if (line.empty() || line[0] != '|' || line.find("`" + name + "`") == line.npos) continue;
      is_told = is_told || std::count(line.begin(), line.end(), '|') >= 4;
      EXPECT_NE(line.find(unit), line.npos) << row.name << ": " << line;
    }
    const bool is_self = row.term == ParameterTerm::kSelfFriction;  // one of "mu.NAME"
    EXPECT_TRUE(is_told || is_self) << row.name;
  }
}

// Whoever asks `identify --help all` finds every name of a scene, and every one of a recording without its axis.
TEST(ParameterTableTest, HelpTellsEveryName) {
  const std::string help = Source("identify/help.h");
  for (const ParameterRow& row : ParameterTable()) {
    const bool is_in_short = row.term == ParameterTerm::kPlacement || IsOfRecording(row.kind);
    const std::string name = is_in_short ? row.name : ParameterName(AxesOf(row).front(), {});
    EXPECT_NE(help.find(name), help.npos) << name;
  }
}

// Pages of reports have the units of the table, with raised digits; none where the law of the air decides.
TEST(ParameterTableTest, ReportsTellTheSameUnits) {
  const std::string script = Source("identify/report/page/page_text.js");
  const std::regex entry(R"('?([a-z_.]+)'?: '([^']*)')");
  const std::size_t begin = script.find("const UNITS = {"), end = script.find("};", begin);
  ASSERT_NE(end, script.npos);
  std::map<std::string, std::string> units;
  const std::string entries = script.substr(begin, end - begin);
  for (std::sregex_iterator it(entries.begin(), entries.end(), entry), last; it != last; ++it) {
    units[(*it)[1]] = std::regex_replace((*it)[2].str(), std::regex("²"), "^2");
  }
  for (const ParameterRow& row : ParameterTable()) {
    if (row.term == ParameterTerm::kPlacement) continue;
    const bool is_told = *row.unit != '\0' && row.term != ParameterTerm::kDirectionalDrag && !IsOfRecording(row.kind);
    for (const ParameterId id : AxesOf(row)) {
      const std::string name = ParameterName(id, {});
      EXPECT_EQ(units[name], is_told ? row.unit : "") << name;
    }
  }
}

TEST(ParameterTableTest, UnitOfDragFollowsTheAir) {
  EXPECT_STREQ(RowOf(ParameterKind::kNormalDrag).UnitIn(AirLaw::kLinear), "kg/(m^2 s)");
  EXPECT_STREQ(RowOf(ParameterKind::kNormalDrag).UnitIn(AirLaw::kQuadratic), "kg/m^3");
  EXPECT_STREQ(RowOf(ParameterKind::kDrag).UnitIn(AirLaw::kQuadratic), "kg/(m^2 s)");
}

}  // namespace
}  // namespace clothid::parameter_table_test
