#include "datasets/curves/curve_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/base/csv_row.h"
#include "sim/base/error.h"
#include "sim/base/table.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr double kLargestReading = 1e9;  // m, N or N/m: beyond it a number is none of a machine

constexpr double kStandardGravity = 9.80665;  // m/s^2

enum class CurveQuantity { kForce, kForcePerWidth, kLength, kStrain };

// A number in this unit times `factor` is one in N, N/m, m or 1.
struct CurveUnit {
  CurveQuantity quantity = CurveQuantity::kForce;
  double factor = 1.0;
};

constexpr std::array<std::string_view, 3> kForceNames = {"force", "load", "kraft"};
constexpr std::array<std::string_view, 9> kElongationNames = {
    "extension", "elongation", "displacement", "stroke", "travel", "position", "weg", "strain", "dehnung"};
constexpr std::array<std::string_view, 2> kWidthNames = {"width", "specimen width"};
constexpr std::array<std::string_view, 3> kGaugeNames = {"gauge length", "gauge", "specimen length"};

constexpr char kForceUnits[] = "N, mN, kN, cN, gf, kgf, N/m, N/cm or N/mm";
constexpr char kElongationUnits[] = "mm, cm, m, % or 1";
constexpr char kExample[] = "Extension [mm];Force [N]";

std::optional<CurveUnit> FindCurveUnit(std::string_view name) {
  static const std::map<std::string, CurveUnit, std::less<>> units = {
      {"cN", {CurveQuantity::kForce, 1e-2}},
      {"gf", {CurveQuantity::kForce, 1e-3 * kStandardGravity}},
      {"kgf", {CurveQuantity::kForce, kStandardGravity}},
      {"N/m", {CurveQuantity::kForcePerWidth, 1.0}},
      {"N/cm", {CurveQuantity::kForcePerWidth, 1e2}},
      {"N/mm", {CurveQuantity::kForcePerWidth, 1e3}},
      {"%", {CurveQuantity::kStrain, 1e-2}},
      {"1", {CurveQuantity::kStrain, 1.0}},
      {"-", {CurveQuantity::kStrain, 1.0}},
      {"mm/mm", {CurveQuantity::kStrain, 1.0}},
      {"m/m", {CurveQuantity::kStrain, 1.0}}};
  if (const auto found = units.find(name); found != units.end()) return found->second;
  const std::optional<Unit> unit = FindUnit(name);
  if (unit && unit->quantity == Quantity::kForce) return CurveUnit{CurveQuantity::kForce, 1.0 / unit->per_si};
  if (unit && unit->quantity == Quantity::kLength) return CurveUnit{CurveQuantity::kLength, 1.0 / unit->per_si};
  return std::nullopt;
}

// "Force [N]" is the name "force" with the unit "N".
struct NamedCell {
  std::string name;  // in small letters
  std::string unit;  // empty: none
};

NamedCell SplitName(std::string_view cell) {
  NamedCell result;
  cell = Trimmed(cell);
  const std::size_t open = cell.find_last_of("[(");
  if (open != std::string_view::npos && open > 0 && (cell.back() == ']' || cell.back() == ')')) {
    result.unit = std::string(Trimmed(cell.substr(open + 1, cell.size() - open - 2)));
    cell = Trimmed(cell.substr(0, open));
  }
  while (!cell.empty() && cell.back() == ':') cell = Trimmed(cell.substr(0, cell.size() - 1));
  result.name = std::string(cell);
  for (char& c : result.name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c | 0x20) : c;
  return result;
}

// The brackets of a row of units, "[mm]", go.
std::string UnitOfCell(std::string_view cell) {
  cell = Trimmed(cell);
  const bool has_brackets =
      cell.size() > 2 && ((cell.front() == '[' && cell.back() == ']') || (cell.front() == '(' && cell.back() == ')'));
  return std::string(has_brackets ? Trimmed(cell.substr(1, cell.size() - 2)) : cell);
}

// How well `name` is one of `names`, 0 the best: its place, the plain one before one with words before it.
template <std::size_t count>
std::optional<std::size_t> Rank(const std::string& name, const std::array<std::string_view, count>& names) {
  for (std::size_t i = 0; i < count; ++i) {
    if (name == names[i]) return 2 * i;
    const std::size_t size = names[i].size();
    if (name.size() > size + 1 && name[name.size() - size - 1] == ' ' &&
        name.compare(name.size() - size, size, names[i]) == 0) {
      return 2 * i + 1;
    }
  }
  return std::nullopt;
}

// As SeparatorOf, but of lines with decimal commas, too: "Width;95,92".
char SeparatorOfCurve(std::string_view line) {
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == ';' && !is_quoted) return ';';
  }
  return SeparatorOf(line);
}

struct CurveColumn {
  std::size_t column = 0;
  std::string title;  // as it stands in the file
  std::string unit;   // empty: not told
  CurveUnit scale;
};

class CurveReader {
 public:
  explicit CurveReader(const std::string& path) : path_(path), text_(ReadText(path, kMaxCurveBytes)), rest_(text_) {}

  CurveTable Read() {
    table_.name = path_;
    FindHeader();
    TakeUnits();
    SetScale(kForceUnits, {CurveQuantity::kForce, CurveQuantity::kForcePerWidth}, &force_);
    SetScale(kElongationUnits, {CurveQuantity::kLength, CurveQuantity::kStrain}, &elongation_);
    table_.is_per_width = force_.scale.quantity == CurveQuantity::kForcePerWidth;
    table_.is_strain = elongation_.scale.quantity == CurveQuantity::kStrain;
    table_.columns = Words(elongation_) + " and " + Words(force_);
    ReadRows();
    return std::move(table_);
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const { FailOnLine(line_, message); }
  [[noreturn]] void FailOnLine(int line, const std::string& message) const {
    throw Error(ErrorKind::kBadData, path_ + ":" + std::to_string(line) + ": " + message);
  }

  static std::string Words(const CurveColumn& column) {
    return "'" + Printable(column.title) + "' in " + Printable(column.unit);
  }

  // The next line with something in it, in cells_; false where there is none.
  bool TakeCells(bool is_above_rows) {
    while (const std::optional<std::string_view> line = TakeLine(&rest_)) {
      ++line_;
      if (Trimmed(*line).empty()) continue;
      if (is_above_rows) separator_ = SeparatorOfCurve(*line);
      if (!SplitCells(*line, separator_, &cells_)) Fail(kExpectedQuotes);
      if (std::any_of(cells_.begin(), cells_.end(), [](const std::string& cell) { return !Trimmed(cell).empty(); })) {
        return true;
      }
    }
    return false;
  }

  bool IsNumber(const std::string& cell) const {
    return CellNumbers(separator_).Parse(std::string(Trimmed(cell))).has_value();
  }

  // The best column of these names; nothing where there is none. Throws where two are as good.
  template <std::size_t count>
  std::optional<CurveColumn> FindColumn(const std::array<std::string_view, count>& names) const {
    std::optional<CurveColumn> best;
    std::size_t best_rank = 0;
    bool is_twice = false;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const NamedCell cell = SplitName(cells_[i]);
      const std::optional<std::size_t> rank = Rank(cell.name, names);
      if (!rank || (best && *rank > best_rank)) continue;
      is_twice = best && *rank == best_rank;
      best = CurveColumn{i, cells_[i], cell.unit, {}};
      best_rank = *rank;
    }
    if (is_twice) Fail("column '" + Printable(best->title) + "': expected once in the header");
    return best;
  }

  void FindHeader() {
    while (TakeCells(true)) {
      const auto is_number = [&](const std::string& cell) { return IsNumber(cell); };
      if (cells_.size() > 1 && std::all_of(cells_.begin(), cells_.end(), is_number)) FailWithoutHeader();
      // A line about the test may have the name of a column: "Preload force";"0,5";"N".
      const bool has_numbers = std::any_of(cells_.begin(), cells_.end(), is_number);
      if (!has_numbers && TakeHeader()) return;
      TakeDimension(kWidthNames, &table_.width);
      TakeDimension(kGaugeNames, &table_.gauge_length);
    }
    const std::string expected =
        std::string("expected a header with columns of force and of extension, displacement or strain, as in '") +
        kExample + "'";
    if (nearly_line_ > 0) FailOnLine(nearly_line_, expected + ", found '" + Printable(nearly_) + "'");
    FailOnData(path_, expected);
  }

  [[noreturn]] void FailWithoutHeader() const {
    const std::string found = nearly_line_ == 0
                                  ? ""
                                  : "; line " + std::to_string(nearly_line_) + ", '" + Printable(nearly_) +
                                        "', does not name both force and extension, displacement or strain";
    Fail(std::string("expected a header above the first row of numbers, as in '") + kExample + "'" + found);
  }

  // Whether the line has both columns.
  bool TakeHeader() {
    const std::optional<CurveColumn> force = FindColumn(kForceNames), elongation = FindColumn(kElongationNames);
    if (force && elongation) {
      force_ = *force;
      elongation_ = *elongation;
      num_cells_ = cells_.size();
      while (num_cells_ > 1 && Trimmed(cells_[num_cells_ - 1]).empty()) --num_cells_;
      return true;
    }
    if ((force || elongation) && nearly_line_ == 0) {
      nearly_line_ = line_;
      for (const std::string& cell : cells_) nearly_ += (nearly_.empty() ? "" : ";") + cell;
    }
    return false;
  }

  // "Width";"95,92";"mm" or "Width [mm]";"95,92".
  template <std::size_t count>
  void TakeDimension(const std::array<std::string_view, count>& names, std::optional<double>* dimension) const {
    const NamedCell key = SplitName(cells_[0]);
    if (std::find(names.begin(), names.end(), key.name) == names.end()) return;
    const std::string number = cells_.size() > 1 ? std::string(Trimmed(cells_[1])) : "";
    const std::optional<double> value = CellNumbers(separator_).Parse(number);
    const std::string source = "'" + Printable(Trimmed(cells_[0])) + "': ";
    if (!value || !(*value > 0.0 && *value <= kLargestReading))
      Fail(source + "expected a number > 0, found '" + Printable(number) + "'");
    const std::string name = key.unit.empty() && cells_.size() > 2 ? UnitOfCell(cells_[2]) : key.unit;
    const std::optional<CurveUnit> unit = FindCurveUnit(name);
    if (!unit || unit->quantity != CurveQuantity::kLength) {
      Fail(source + "expected a unit, mm, cm or m, found '" + Printable(name) + "'");
    }
    *dimension = *value * unit->factor;
  }

  // A row below the header without a number in either column.
  void TakeUnits() {
    const std::string_view rest = rest_;
    header_line_ = units_line_ = line_;
    if (TakeCells(false) && cells_.size() > std::max(force_.column, elongation_.column) &&
        !IsNumber(cells_[force_.column]) && !IsReading(cells_[elongation_.column])) {
      units_line_ = line_;
      for (CurveColumn* column : {&force_, &elongation_}) {
        const std::string unit = UnitOfCell(cells_[column->column]);
        if (!unit.empty()) column->unit = unit;
      }
      return;
    }
    rest_ = rest;
    line_ = header_line_;
  }

  // The unit of a strain may be "1".
  bool IsReading(const std::string& cell) const { return IsNumber(cell) && UnitOfCell(cell) != "1"; }

  void SetScale(const char* expected, std::array<CurveQuantity, 2> quantities, CurveColumn* column) const {
    const std::optional<CurveUnit> unit = FindCurveUnit(column->unit);
    if (unit && (unit->quantity == quantities[0] || unit->quantity == quantities[1])) {
      column->scale = *unit;
      return;
    }
    const std::string source = "column '" + Printable(column->title) + "': ";
    if (column->unit.empty()) {
      FailOnLine(header_line_, source + "expected a unit in brackets or in a row below, " + expected + ", found none");
    }
    FailOnLine(units_line_, source + "expected the unit " + expected + ", found '" + Printable(column->unit) + "'");
  }

  void ReadRows() {
    CellNumbers numbers(separator_);
    std::vector<double> elongations, forces;
    while (TakeCells(false)) {
      while (cells_.size() > num_cells_ && Trimmed(cells_.back()).empty()) cells_.pop_back();
      if (cells_.size() != num_cells_) {
        Fail("expected " + std::to_string(num_cells_) + " cells as in the header, found " +
             std::to_string(cells_.size()) +
             (separator_ == ',' && cells_.size() > num_cells_ ? "; a decimal comma needs ';' or tabs between cells"
                                                              : ""));
      }
      elongations.push_back(Number(elongation_, &numbers));
      forces.push_back(Number(force_, &numbers));
    }
    if (forces.empty()) FailOnLine(units_line_, "expected rows of numbers below the header");
    table_.elongations =
        Eigen::Map<const Eigen::VectorXd>(elongations.data(), static_cast<Eigen::Index>(elongations.size()));
    table_.forces = Eigen::Map<const Eigen::VectorXd>(forces.data(), static_cast<Eigen::Index>(forces.size()));
  }

  double Number(const CurveColumn& column, CellNumbers* numbers) const {
    const std::string cell(Trimmed(cells_[column.column]));
    const std::optional<double> value = numbers->Parse(cell);
    if (!value || !(std::abs(*value * column.scale.factor) <= kLargestReading)) {
      Fail("column '" + Printable(column.title) + "': expected a " + (value ? "smaller" : "finite") +
           " number, found '" + Printable(cell) + "'" + numbers->LikelyCause(cell));
    }
    return *value * column.scale.factor;
  }

  const std::string path_, text_;
  std::string_view rest_;
  int line_ = 0, header_line_ = 0, units_line_ = 0;
  char separator_ = ',';
  std::size_t num_cells_ = 0;  // of the header
  int nearly_line_ = 0;        // the first line with one of both columns; 0: none
  std::string nearly_;         // what stands in it
  std::vector<std::string> cells_;
  CurveColumn force_, elongation_;
  CurveTable table_;
};

}  // namespace

CurveTable ReadCurveTable(const std::string& path) { return CurveReader(path).Read(); }

}  // namespace clothid
