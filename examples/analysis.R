# Reads an export of `mos export` and computes its mean opinion scores and tests again with base R.
#
#     mos export sessions/STUDY -o export
#     Rscript analysis.R export [A B]
#
# For each study, prints the mean opinion scores by scene and method with 90 % intervals, and the signed-rank test of
# method A against method B. Without A and B the first two methods in alphabetical order are tested. Writes mos.csv,
# test.csv and mos.pdf into the export's folder. The figures agree with those of `mos table` and `mos test`: the
# participant is the unit, zero differences are dropped before ranking, and p is asymptotic without continuity
# correction. The exact p of `mos` allows for ties. That of wilcox.test does not, but that of the package `coin` does.
# The export's own analysis.R fits a mixed model to the same file.

level <- 0.90
arguments <- commandArgs(trailingOnly = TRUE)
if (!length(arguments) %in% c(1, 3)) stop("usage: analysis.R FOLDER [A B]")
folder <- arguments[1]
answers <- read.csv(file.path(folder, "responses.csv"), colClasses = c(participant = "character"))
trials <- subset(answers, purpose == "trial")
kinds <- unique(trials$kind)
if (length(kinds) != 1) stop(folder, " holds sessions of several kinds; export one with --kind")
if (kinds != "real") cat("***", toupper(kinds), "data ***\n")

# Means, standard deviations and intervals over participants.
people <- aggregate(rating ~ participant + method + scene + study, trials, mean)
cells <- aggregate(rating ~ method + scene + study, people, function(x) c(n = length(x), mean = mean(x), sd = sd(x)))
mos <- data.frame(cells[c("study", "scene", "method")], cells$rating)
half <- qt(0.5 + level / 2, pmax(mos$n - 1, 1)) * mos$sd / sqrt(mos$n)
mos$lo <- mos$mean - half
mos$hi <- mos$mean + half

# The signed-rank test of each participant's sum of votes, for the participants who have every cell of both methods.
signed_rank <- function(trials, a, b) {
  trials <- trials[trials$method %in% c(a, b), ]
  votes <- tapply(trials$rating, list(trials$participant, interaction(trials$scene, trials$repetition), trials$method), sum)
  whole <- apply(!is.na(votes), 1, all)
  d <- rowSums(votes[whole, , a, drop = FALSE]) - rowSums(votes[whole, , b, drop = FALSE])
  used <- d[d != 0]
  p <- if (length(used)) wilcox.test(used, exact = FALSE, correct = FALSE)$p.value else 1
  ranks <- rank(abs(used))
  data.frame(a = a, b = b, n = length(d), zeros = sum(d == 0), mean_difference = mean(d) / dim(votes)[2],
             r_plus = sum(ranks[used > 0]), r_minus = sum(ranks[used < 0]), p_asymptotic = p)
}
tests <- do.call(rbind, lapply(split(trials, trials$study), function(rows) {
  pair <- if (length(arguments) == 3) arguments[2:3] else sort(unique(rows$method))[1:2]
  cbind(study = rows$study[1], signed_rank(rows, pair[1], pair[2]))
}))

write.csv(mos, file.path(folder, "mos.csv"), row.names = FALSE)
write.csv(tests, file.path(folder, "test.csv"), row.names = FALSE)
print(mos, digits = 4, row.names = FALSE)
print(tests, digits = 4, row.names = FALSE)

pdf(file.path(folder, "mos.pdf"), width = 7, height = 4)
for (rows in split(mos, mos$study)) {
  scenes <- sort(unique(rows$scene))
  methods <- sort(unique(rows$method))
  at <- match(rows$scene, scenes) + 0.15 * (match(rows$method, methods) - (length(methods) + 1) / 2)
  plot(at, rows$mean, pch = 14 + match(rows$method, methods), xaxt = "n", xlab = "scene", ylab = "mean opinion score",
       main = rows$study[1], xlim = c(0.5, length(scenes) + 0.5), ylim = range(rows$lo, rows$hi, rows$mean, na.rm = TRUE))
  known <- !is.na(rows$lo) & rows$hi > rows$lo
  arrows(at[known], rows$lo[known], at[known], rows$hi[known], angle = 90, code = 3, length = 0.05)
  axis(1, seq_along(scenes), scenes)
  legend("topleft", methods, pch = 14 + seq_along(methods), bty = "n")
}
invisible(dev.off())
