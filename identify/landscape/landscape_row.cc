#include "identify/landscape/landscape_row.h"

#include <cmath>
#include <limits>
#include <optional>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

std::string TextOrNothing(double value) { return std::isnan(value) ? std::string() : ShortestText(value); }

// In double quotes, each of its own doubled.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c == '\n' || c == '\r' ? ' ' : c);
  return quoted + "\"";
}

std::optional<std::string> Unquoted(std::string_view text) {
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return std::nullopt;
  text = text.substr(1, text.size() - 2);
  std::string unquoted;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"' && (++i == text.size() || text[i] != '"')) return std::nullopt;
    unquoted += text[i];
  }
  return unquoted;
}

// Takes the columns of a row one after the other.
class RowReader {
 public:
  RowReader(std::string_view row, const std::string& source) : rest_(row), source_(source) {}

  void Expect(bool condition, const char* column, const char* expected) const {
    if (!condition) FailOnData(source_, std::string("column '") + column + "': expected " + expected);
  }
  int Count(const char* column) {
    const std::optional<long long> value = ParseInteger(Take(column));
    Expect(value && *value >= 0 && *value <= std::numeric_limits<int>::max(), column, "a count");
    return static_cast<int>(*value);
  }
  // NaN where the column is empty.
  double Number(const char* column) {
    const std::string_view text = Take(column);
    const std::optional<double> value = ParseNumber(text);
    Expect(value || text.empty(), column, "a finite number");
    return value.value_or(std::numeric_limits<double>::quiet_NaN());
  }
  std::string_view rest() const { return rest_; }

  std::string_view Take(const char* column) {
    const std::size_t comma = rest_.find(',');
    Expect(comma != std::string_view::npos, column, "more columns");
    const std::string_view text = rest_.substr(0, comma);
    rest_.remove_prefix(comma + 1);
    return text;
  }

 private:
  std::string_view rest_;
  const std::string& source_;
};

// Whether the axes of this machine, whose exp() may round in another way, put a cell where it was.
bool IsAt(double found, double expected) { return std::abs(found - expected) <= 1e-12 * std::abs(expected); }

constexpr char kOfThePlan[] = "that of this cell in the plan";

void ReadPlace(const LandscapePlan& plan, int cell, RowReader* reader) {
  const LandscapePlace place = plan.PlaceOf(cell);
  const LandscapeWindow& window = plan.windows[place.window];
  const LandscapeSetting& setting = plan.settings[place.setting];
  reader->Expect(IsAt(reader->Number("x"), window.x.Value(place.ix)), "x", kOfThePlan);
  reader->Expect(IsAt(reader->Number("y"), window.y.Value(place.iy)), "y", kOfThePlan);
  reader->Expect(reader->Take("setting") == setting.name, "setting", kOfThePlan);
  reader->Expect(reader->Take("contact") == ContactModeName(setting.contact_mode), "contact", kOfThePlan);
}

}  // namespace

std::string RowHeader(const LandscapePlan& plan) {
  return std::string("x,y,setting,contact,cost,contact_changes,contacts,failed_steps,zoom,nodes_joined,nodes_left,") +
         "branch_switches,obstacle_switches,pair_changes,steps,substeps" +
         (plan.has_gradients ? ",gradient_x,gradient_y" : "") + ",failure";
}

std::string CellRow(const LandscapePlan& plan, int cell, const LandscapeCell& result) {
  const LandscapePlace place = plan.PlaceOf(cell);
  const LandscapeWindow& window = plan.windows[place.window];
  const LandscapeSetting& setting = plan.settings[place.setting];
  const RolloutCounts& counts = result.counts;
  std::string row = ShortestText(window.x.Value(place.ix)) + "," + ShortestText(window.y.Value(place.iy)) + "," +
                    setting.name + "," + ContactModeName(setting.contact_mode) + "," + TextOrNothing(result.cost);
  for (const int count : {counts.contact_changes(), counts.contacts, counts.failed_steps}) {
    row += "," + std::to_string(count);
  }
  row += "," + ShortestText(window.zoom);
  for (const int count : {counts.nodes_joined, counts.nodes_left, counts.branch_switches, counts.obstacle_switches,
                          counts.pair_changes, counts.steps, counts.substeps}) {
    row += "," + std::to_string(count);
  }
  if (plan.has_gradients) row += "," + TextOrNothing(result.gradient_x) + "," + TextOrNothing(result.gradient_y);
  return row + "," + (result.failure.empty() ? "" : Quoted(result.failure));
}

LandscapeCell ParseRow(const LandscapePlan& plan, int cell, std::string_view row, const std::string& source) {
  RowReader reader(row, source);
  ReadPlace(plan, cell, &reader);
  LandscapeCell result;
  RolloutCounts& counts = result.counts;
  result.cost = reader.Number("cost");
  const int contact_changes = reader.Count("contact_changes");
  counts.contacts = reader.Count("contacts");
  counts.failed_steps = reader.Count("failed_steps");
  reader.Expect(reader.Number("zoom") == plan.windows[plan.PlaceOf(cell).window].zoom, "zoom", kOfThePlan);
  counts.nodes_joined = reader.Count("nodes_joined");
  counts.nodes_left = reader.Count("nodes_left");
  counts.branch_switches = reader.Count("branch_switches");
  counts.obstacle_switches = reader.Count("obstacle_switches");
  counts.pair_changes = reader.Count("pair_changes");
  counts.steps = reader.Count("steps");
  counts.substeps = reader.Count("substeps");
  // May be no int.
  const long long sum = 0LL + counts.nodes_joined + counts.nodes_left + counts.branch_switches + counts.pair_changes;
  reader.Expect(contact_changes == sum, "contact_changes", "the sum of its parts");
  const bool failed = std::isnan(result.cost);
  if (plan.has_gradients) {
    result.gradient_x = reader.Number("gradient_x");
    result.gradient_y = reader.Number("gradient_y");
    reader.Expect(std::isnan(result.gradient_x) == failed && std::isnan(result.gradient_y) == failed, "gradient_x",
                  "gradients where there is a cost");
  }
  const std::optional<std::string> failure = Unquoted(reader.rest());
  reader.Expect(failed ? failure && !failure->empty() : reader.rest().empty(), "failure",
                "a reason in quotes, or a cost");
  if (failed) result.failure = *failure;
  return result;
}

}  // namespace clothid
