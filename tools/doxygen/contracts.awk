# Doxygen's input filter: the // contracts of our headers as Doxygen comments. A comment that stands alone documents what
# follows, one behind code that code, the first one the file; lines indented within a comment are formulas.
function leave_formula() {
  if (in_formula) print indent "/// \\endcode"
  in_formula = 0
}
NR == 1 { print "/// \\file" }
/^ *\/\// {
  match($0, /^ */)
  indent = substr($0, 1, RLENGTH)
  text = substr($0, RLENGTH + 3)
  is_formula = text ~ /^   *[^ -]/
  if (!is_formula) leave_formula()
  if (is_formula && !in_formula) print indent "/// \\code{.unparsed}"
  in_formula = is_formula
  if (!is_formula && text !~ /`/) gsub(/</, "\\&lt;", text)  # not the start of an HTML tag
  print indent "///" text
  next
}
{
  leave_formula()
  if ($0 !~ /^[#}]/) sub(/  \/\/ /, "  ///< ")
  print
}
