// Tables as spreadsheets, loggers and editors leave them: whatever they are of, each is read to the same values as a
// plain one, or refused with file and line.
#include <gtest/gtest.h>

#include <cctype>
#include <functional>
#include <string>
#include <vector>

#include "datasets/formats/ros_csv.h"
#include "datasets/formats/tracks_csv.h"
#include "datasets/importing/clock_times.h"
#include "datasets/importing/force_file.h"
#include "datasets/importing/point_map.h"
#include "sim/path/handle_csv.h"
#include "sim/path/pose_csv.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::odd_tables_test {
namespace {

using Cells = std::vector<std::string>;

struct Kind {
  std::string name;
  Cells header, units;  // without units: it has no numbers in any
  std::vector<Cells> rows;
  std::function<Eigen::VectorXd(const std::string& path)> read;
  bool has_times = true;  // which have to increase
};

Eigen::VectorXd Joined(const Eigen::VectorXd& times, const Eigen::MatrixXd& values) {
  Eigen::VectorXd all(times.size() + values.size());
  all << times, values.reshaped();
  return all;
}

Eigen::VectorXd ReadMap(const std::string& path) {
  PointTracks tracks;
  tracks.positions.resize(12, 1);
  const PointMap map = ReadPointMap(path, tracks, MakePointGrid({2, 2}, {1.0, 1.0}, false));
  Eigen::VectorXd values = map.barycentric.reshaped();
  for (const std::vector<int>& list : {map.points, map.node_index, map.face_index}) {
    for (const int index : list) {
      values.conservativeResize(values.size() + 1);
      values[values.size() - 1] = index;
    }
  }
  return values;
}

Eigen::VectorXd ReadForceTable(const std::string& path) {
  ForceFile file;
  file.path = path;
  file.sigma = 1.0;
  const ForceReadings forces = ReadForces(file, Eigen::Vector2d(0.0, 1.0), 0.0);
  return Joined(forces.times, forces.values(std::vector<int>{0, 2}, Eigen::all));
}

const std::vector<Kind>& Kinds() {
  const auto points = [](const PointTracks& tracks) { return Joined(tracks.times, tracks.positions); };
  static const std::vector<Kind> kinds = {
      {"points",
       {"t", "id", "x", "y", "z"},
       {"s", "-", "m", "m", "m"},
       {{"0", "a", "0.5", "1", "2"}, {"0.25", "a", "1.5", "2", "3"}},
       [=](const std::string& path) { return points(ReadTracksCsv(path)); },
       false},
      {"wide points",
       {"%time", "field.size", "field.x0", "field.y0", "field.z0"},
       {},
       {{"0", "1", "0.5", "1", "2"}, {"250000000", "1", "1.5", "2", "3"}},
       [=](const std::string& path) { return points(ReadRosGrid(path)); }},
      {"forces", {"time", "x", "z"}, {"s", "N", "N"}, {{"0", "0.5", "1"}, {"0.25", "1.5", "2"}}, &ReadForceTable},
      {"handles",
       {"time", "x0", "y0", "z0"},
       {"s", "m", "m", "m"},
       {{"0", "0.5", "1", "2"}, {"0.25", "1.5", "2", "3"}},
       [](const std::string& path) {
         const HandlePath handles = ReadHandleCsv(path, 1);
         return Joined(handles.times(), handles.positions());
       }},
      {"obstacle",
       {"time", "x", "y", "z", "qx", "qy", "qz", "qw"},
       {"s", "m", "m", "m", "", "", "", ""},
       {{"0", "0.5", "1", "2", "0", "0", "0", "1"}, {"0.25", "1.5", "2", "3", "0", "0", "0", "1"}},
       [](const std::string& path) {
         const RigidPath poses = ReadPoseCsv(path);
         return Joined(poses.times(), poses.positions());
       }},
      {"map of nodes", {"id", "node"}, {}, {{"0", "1"}, {"2", "3"}}, &ReadMap, false},
      {"map of places",
       {"id", "face", "b0", "b1", "b2"},
       {},
       {{"0", "1", "0.5", "0.25", "0.25"}, {"2", "0", "0.25", "0.5", "0.25"}},
       &ReadMap,
       false},
      {"times", {"time"}, {"s"}, {{"0"}, {"0.25"}}, &ReadTimes}};
  return kinds;
}

// The text of a table, whose cells `write` puts down.
std::string Text(const Kind& kind, const std::string& separator = ",", const std::string& end = "\n",
                 const std::function<std::string(std::string)>& write = nullptr) {
  std::string text;
  std::vector<Cells> lines = {kind.header};
  lines.insert(lines.end(), kind.rows.begin(), kind.rows.end());
  for (const Cells& cells : lines) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      text += (i > 0 ? separator : "") + (write ? write(cells[i]) : cells[i]);
    }
    text += end;
  }
  return text;
}

std::string InCapitals(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string WithCommas(std::string cell) {
  if (std::isdigit(static_cast<unsigned char>(cell[0])) && cell.find('.') != std::string::npos) {
    cell[cell.find('.')] = ',';
  }
  return cell;
}

class OddTablesTest : public testing::Test {
 protected:
  Eigen::VectorXd Read(const Kind& kind, const std::string& text) const {
    return kind.read(folder_.Write("odd.csv", text));
  }
  void ExpectSame(const Kind& kind, const std::string& text) const {
    SCOPED_TRACE(kind.name + ":\n" + text);
    EXPECT_NO_THROW(EXPECT_EQ(Read(kind, text), Read(kind, Text(kind))));
  }
  void ExpectRefused(const Kind& kind, const std::string& text, std::initializer_list<const char*> fragments) const {
    SCOPED_TRACE(kind.name + ":\n" + text);
    ExpectError([&] { Read(kind, text); }, ErrorKind::kBadData, fragments);
  }

  TemporaryFolder folder_;
};

TEST_F(OddTablesTest, AreReadAlike) {
  for (const Kind& kind : Kinds()) {
    ExpectSame(kind, "\xef\xbb\xbf" + Text(kind));
    ExpectSame(kind, Text(kind, ",", "\r\n"));
    ExpectSame(kind, Text(kind, ",", "\n", [](const std::string& cell) { return '"' + cell + '"'; }));
    ExpectSame(kind, Text(kind, ", "));
    ExpectSame(kind, Text(kind, ",", ",\n"));
    ExpectSame(kind, Text(kind, ",", "\n\n"));
    ExpectSame(kind, Text(kind) + ",,\n");
    Kind more = kind;
    more.header.push_back("note");
    for (Cells& row : more.rows) row.push_back("seen, 3 times");
    ExpectSame(kind, Text(more, ",", "\n", [](const std::string& cell) { return '"' + cell + '"'; }));
    ExpectSame(kind, Text(more, ";"));
    if (kind.name != "wide points") {
      Kind loud = kind;
      for (std::string& cell : loud.header) cell = InCapitals(cell);
      ExpectSame(kind, Text(loud));
    }
    if (kind.header.size() == 1) continue;  // has nothing between cells
    ExpectSame(kind, Text(kind, ";"));
    ExpectSame(kind, Text(kind, ";", "\n", &WithCommas));
    ExpectSame(kind, Text(kind, "\t", "\n", &WithCommas));
  }
}

TEST_F(OddTablesTest, HaveUnits) {
  for (const Kind& kind : Kinds()) {
    if (kind.units.empty()) continue;
    Kind with_units = kind;
    with_units.rows.insert(with_units.rows.begin(), kind.units);
    ExpectSame(kind, Text(with_units));
    if (kind.header.size() > 1) ExpectSame(kind, Text(with_units, ";", "\r\n", &WithCommas));
    with_units.rows.front().front() = "kg";
    if (kind.header.size() > 1) ExpectRefused(kind, Text(with_units), {"odd.csv:2: unit of column", "found 'kg'"});
  }
}

TEST_F(OddTablesTest, AreRefusedAlike) {
  for (const Kind& kind : Kinds()) {
    const auto with = [&](std::size_t column, const std::string& cell) {
      Kind changed = kind;
      changed.rows[1][column] = cell;
      return Text(changed);
    };
    const std::size_t last = kind.header.size() - 1;
    ExpectRefused(kind, with(last, "soon"), {"odd.csv:3: column '", "found 'soon'"});
    ExpectRefused(kind, with(last, "\"0,5\""), {"odd.csv:3: column '", "found '0,5'"});
    ExpectRefused(kind, with(0, "nan"), {"odd.csv:3: column '", "found 'nan'"});
    ExpectRefused(kind, with(last, "\"1"), {"odd.csv:3: expected quoted cells to end"});
    ExpectRefused(kind, Text(kind) + "1,1,1,1,1,1,1,1,1,1\n", {"odd.csv:4: expected", "decimal commas"});
    ExpectRefused(kind, "", {"odd.csv: expected the header"});
    ExpectRefused(kind, "when,what\n1,2\n", {"odd.csv:1: ", "found 'when,what'"});
    if (kind.has_times) {
      ExpectRefused(kind, with(0, "0"), {"odd.csv:3: "});
      ExpectRefused(kind, Text(kind) + Text(kind).substr(Text(kind).find('\n') + 1), {"odd.csv:4: "});
    }
    if (last == 0) continue;
    ExpectRefused(kind, Text(kind) + "0.5\n", {"odd.csv:4: expected", "cells as in the header, found 1"});
    ExpectRefused(kind, Text(kind, " "), {"odd.csv:1: ", "one cell"});
    ExpectRefused(kind, Text(kind, "\t") + "1 1\n", {"odd.csv:4: expected", "turn its tabs into blanks?"});
    ExpectRefused(kind, Text(kind) + "1;1\n", {"odd.csv:4: expected", "expected ',' between cells"});
  }
}

}  // namespace
}  // namespace clothid::odd_tables_test
