// The plotting library for pages that a browser opens.
#ifndef CLOTHID_TOOLS_VENDOR_PLOTLY_H_
#define CLOTHID_TOOLS_VENDOR_PLOTLY_H_

#include <string_view>

namespace clothid {

// The text of plotly.min.js (see README.md), to stand in a <script> of the page: then there is `Plotly`. Traces:
// scatter, heatmap, contour, surface, mesh3d, scatter3d.
std::string_view PlotlyLibrary();

}  // namespace clothid

#endif  // CLOTHID_TOOLS_VENDOR_PLOTLY_H_
