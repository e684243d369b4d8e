#include "tools/benchmark/fits/figure3_table.h"

#include <algorithm>
#include <iomanip>
#include <limits>
#include <ostream>
#include <sstream>
#include <vector>

#include "sim/base/text_file.h"

namespace clothid {
namespace {

// Roughness above which a landscape counts as rough in the comparison of the modes.
constexpr double kRough = 5e-3;

int NumWindows(const Figure3& figure) { return static_cast<int>(figure.summary.plan.windows.size()); }

std::vector<double> Touches(const Figure3& figure) {
  std::vector<double> touches;
  for (const Figure3Setting& setting : figure.settings) {
    const bool is_new = std::find(touches.begin(), touches.end(), setting.touch) == touches.end();
    if (setting.contact_mode == ContactMode::kVelocity && is_new) touches.push_back(setting.touch);
  }
  return touches;
}

int FitsPerSetting(const Figure3& figure) { return static_cast<int>(figure.fits.size() / figure.settings.size()); }

// "24 of 25".
std::string FitsOf(const Figure3& figure, int setting, double noise) {
  int num_fits = 0, num_reached = 0;
  for (int i = 0; i < FitsPerSetting(figure); ++i) {
    const JacobianFit& fit = figure.fits[setting * FitsPerSetting(figure) + i];
    num_fits += fit.noise == noise;
    num_reached += fit.noise == noise && fit.reached;
  }
  return num_fits == 0 ? "-" : std::to_string(num_reached) + " of " + std::to_string(num_fits);
}

void WriteHeader(const Figure3& figure, std::ostream& out) {
  const int num_zooms = NumWindows(figure) - 1;
  out << " offset  contact     touch  contacts   joined    branch  failed" << std::setw(11 * num_zooms) << "roughness"
      << std::setw(24) << "fits that find it"
      << "\n"
      << "      m                      per step   + left  switches   steps";
  for (int w = 1; w <= num_zooms; ++w) {
    out << std::setw(11) << "zoom " + ShortestText(figure.summary.plan.windows[w].zoom);
  }
  for (const double noise : figure.noises) out << std::setw(12) << "noise " + ShortestText(noise);
  out << "\n";
}

void WriteSetting(const Figure3& figure, int s, std::ostream& out) {
  const Figure3Setting& setting = figure.settings[s];
  const bool is_gap = setting.contact_mode == ContactMode::kGap;
  const ContactMeans& contact = figure.summary.Of(s, NumWindows(figure) - 1).contact;
  long long failed_steps = 0;
  for (int w = 0; w < NumWindows(figure); ++w) failed_steps += figure.summary.Of(s, w).failed_steps;
  out << std::fixed << std::setprecision(3) << std::setw(7) << setting.offset << "  " << std::left << std::setw(8)
      << ContactModeName(setting.contact_mode) << std::right << std::setw(9)
      << (is_gap ? "-" : ShortestText(setting.touch)) << std::setprecision(1) << std::setw(10)
      << contact.contacts_per_step << std::setw(9) << contact.nodes_joined + contact.nodes_left << std::setw(10)
      << contact.branch_switches << std::setw(8) << failed_steps << std::scientific;
  for (int w = 1; w < NumWindows(figure); ++w) {
    out << std::setw(11) << figure.summary.Of(s, w).roughness.off_quadratic;
  }
  for (const double noise : figure.noises) out << std::setw(12) << FitsOf(figure, s, noise);
  out << std::defaultfloat << std::setprecision(6) << "\n";
}

void WriteCorrelations(const Figure3& figure, std::ostream& out) {
  out << "rank correlation of roughness with contact events in velocity mode, and p-value:\n";
  for (const double touch : Touches(figure)) {
    out << std::setw(60) << "touch " + ShortestText(touch) << std::string(6, ' ') << std::fixed << std::setprecision(2);
    for (int w = 1; w < NumWindows(figure); ++w) {
      const RankCorrelation correlation = RoughnessAgainstEvents(figure, touch, w);
      out << "  " << correlation.rho << " " << correlation.p_value;
    }
    out << std::defaultfloat << std::setprecision(6) << "\n";
  }
}

// Over all velocity settings and zooms that are rough: how much smoother gap mode is there, by both measures.
void WriteComparison(const Figure3& figure, std::ostream& out) {
  int gap = -1, num_compared = 0;
  std::vector<double> off_quadratic, second_difference;  // times smoother
  for (int s = 0; s < static_cast<int>(figure.settings.size()); ++s) {
    if (figure.settings[s].contact_mode == ContactMode::kGap) {
      gap = s;
      continue;
    }
    for (int w = 1; w < NumWindows(figure); ++w) {
      const LandscapeRoughness &rough = figure.summary.Of(s, w).roughness,
                               &smooth = figure.summary.Of(gap, w).roughness;
      ++num_compared;
      if (!(rough.off_quadratic > kRough)) continue;
      off_quadratic.push_back(rough.off_quadratic / smooth.off_quadratic);
      second_difference.push_back(rough.second_difference / smooth.second_difference);
    }
  }
  out << off_quadratic.size() << " of " << num_compared << " zooms in velocity mode are rough (> " << kRough << ")";
  if (off_quadratic.empty()) {
    out << "\n";
    return;
  }
  const auto least = [](const std::vector<double>& ratios) { return *std::min_element(ratios.begin(), ratios.end()); };
  const auto num_threefold =
      std::count_if(off_quadratic.begin(), off_quadratic.end(), [](double r) { return r >= 3.0; });
  out << std::setprecision(3) << "; gap mode is smoother there by " << least(off_quadratic) << " to "
      << *std::max_element(off_quadratic.begin(), off_quadratic.end()) << " times, in " << num_threefold
      << " of them by 3 or more;\nby second differences, which leave smooth curvature out, by at least "
      << least(second_difference) << " times\n"
      << std::setprecision(6);
}

void WriteSettingCsv(const Figure3Setting& setting, std::ostream& out) {
  out << setting.offset << "," << ContactModeName(setting.contact_mode) << "," << setting.touch;
}

}  // namespace

RankCorrelation RoughnessAgainstEvents(const Figure3& figure, double touch, int window) {
  std::vector<double> events, roughness;
  for (int s = 0; s < static_cast<int>(figure.settings.size()); ++s) {
    if (figure.settings[s].contact_mode != ContactMode::kVelocity || figure.settings[s].touch != touch) continue;
    events.push_back(figure.summary.Of(s, window).contact.contact_changes);
    roughness.push_back(figure.summary.Of(s, window).roughness.off_quadratic);
  }
  return SpearmanCorrelation(events, roughness);
}

std::string Figure3Table(const Figure3& figure) {
  std::ostringstream out;
  WriteHeader(figure, out);
  for (int s = 0; s < static_cast<int>(figure.settings.size()); ++s) WriteSetting(figure, s, out);
  WriteCorrelations(figure, out);
  WriteComparison(figure, out);
  return out.str();
}

std::string Figure3Csv(const Figure3& figure) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10);
  out << "offset,contact,touch,zoom,off_quadratic,second_difference,range,contacts,set_changes,branch_switches,"
         "substeps,failed_cells\n";
  for (int s = 0; s < static_cast<int>(figure.settings.size()); ++s) {
    for (int w = 0; w < NumWindows(figure); ++w) {
      const WindowSummary& window = figure.summary.Of(s, w);
      WriteSettingCsv(figure.settings[s], out);
      out << "," << figure.summary.plan.windows[w].zoom << "," << window.roughness.off_quadratic << ","
          << window.roughness.second_difference << "," << window.roughness.range << ","
          << window.contact.contacts_per_step << "," << window.contact.nodes_joined + window.contact.nodes_left << ","
          << window.contact.branch_switches << "," << window.substeps << "," << window.roughness.failed_cells << "\n";
    }
  }
  return out.str();
}

std::string Figure3FitsCsv(const Figure3& figure) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10);
  out << "offset,contact,touch,noise,start_mu,start_k_stretch,mu,k_stretch,cost,reached,rollouts,failed_steps,status\n";
  for (std::size_t i = 0; i < figure.fits.size(); ++i) {
    const JacobianFit& fit = figure.fits[i];
    WriteSettingCsv(figure.settings[i / FitsPerSetting(figure)], out);
    out << "," << fit.noise << "," << fit.start[0] << "," << fit.start[1] << "," << fit.value[0] << "," << fit.value[1]
        << "," << fit.cost << "," << fit.reached << "," << fit.rollouts << "," << fit.failed_steps << ","
        << FitStatusName(fit.status) << "\n";
  }
  return out.str();
}

}  // namespace clothid
