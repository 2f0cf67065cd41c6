# Mixed-effects models of the answers, and the same proportions and tails from R: equilux-analyze export and report made the files.
# Usage: Rscript analysis/r/mixed_models.R answers.csv cells.csv
# Debian packages: r-base-core r-cran-lme4 r-cran-psyphy. source: Knoblauch and Maloney 2012, chapters 4 and 9.
suppressPackageStartupMessages({
  library(lme4)
  library(psyphy)
})

arguments <- commandArgs(trailingOnly = TRUE)
if (length(arguments) != 2) stop("usage: mixed_models.R answers.csv cells.csv")

# Only numbers may be missing: a code or a token "NA", "T" or "1e3" is text.
read_table <- function(file) {
  texts <- c("study", "experiment", "participant", "geometry", "material", "illumination", "clamp", "status")
  header <- names(read.csv(file, nrows = 1, check.names = FALSE))
  classes <- ifelse(header %in% texts, "character", NA)
  read.csv(file, stringsAsFactors = FALSE, na.strings = "", colClasses = classes, check.names = FALSE)
}
answers <- read_table(arguments[1])
cells <- read_table(arguments[2])
answers$participant[is.na(answers$participant)] <- ""
if (anyNA(answers)) stop("answers.csv: fields are missing in ", paste(names(answers)[colSums(is.na(answers)) > 0], collapse = ", "))

# Held against the report: counts exactly, all else to 1e-9. Stops where they differ.
compare_cells <- function(answers, cells) {
  key <- c("study", "experiment", "geometry", "material", "illumination", "vpls", "clamp")
  name <- function(rows) do.call(paste, c(rows[key], sep = "/"))
  tested <- cells[cells$n > 0, ]
  k <- tapply(answers$correct, name(answers), sum)[name(tested)]
  n <- tapply(answers$correct, name(answers), length)[name(tested)]
  near <- function(what, ours, theirs) {
    difference <- max(abs(ours - theirs))
    if (!is.finite(difference) || difference > 1e-9) stop(what, " differ by ", difference)
    cat(sprintf("%-24s %d cells agree, largest difference %.1e\n", what, length(ours), difference))
  }
  near("k", tested$k, as.vector(k))
  near("n", tested$n, as.vector(n))
  exact <- mapply(function(k, n) {
    two <- binom.test(k, n)
    c(two$conf.int, binom.test(k, n, alternative = "greater")$p.value)
  }, tested$k, tested$n)
  near("Clopper-Pearson, lower", tested$cp_lower, exact[1, ])
  near("Clopper-Pearson, upper", tested$cp_upper, exact[2, ])
  near("p by guessing", tested$p_guess, exact[3, ])
  near("Jeffreys, lower", tested$jeffreys_lower,
       ifelse(tested$k == 0, 0, qbeta(0.025, tested$k + 0.5, tested$n - tested$k + 0.5)))
  near("Jeffreys, upper", tested$jeffreys_upper,
       ifelse(tested$k == tested$n, 1, qbeta(0.975, tested$k + 0.5, tested$n - tested$k + 0.5)))
  near("P(over 75 %)", tested$posterior_over,
       pbeta(0.75, tested$k + 0.5, tested$n - tested$k + 0.5, lower.tail = FALSE))
  family <- paste(tested$study, tested$experiment)
  near("q", tested$q_guess, ave(tested$p_guess, family, FUN = function(p) p.adjust(p, "BH")))
}

# Centred, and scaled to a standard deviation of one: coefficients are for one standard deviation of clamp level or log10 of VPLs.
standardise <- function(values) if (length(unique(values)) > 1) as.vector(scale(values)) else values * 0

# What is tried in turn: the mixed model by Laplace's approximation, by two optimisers; then with nAGQ = 0, which sets fixed effects and
# subjects in one step and is no maximum of the likelihood; and last a model of fixed effects, without subjects.
make_attempts <- function(terms, rows) {
  fixed <- paste("correct ~", paste(terms, collapse = " + "))
  mixed <- as.formula(paste(fixed, "+ (1 | participant)"))
  link <- binomial(mafc.logit(.m = 2))
  fit_mixed <- function(optimizer, quadrature) function() {
    glmer(mixed, data = rows, family = link, nAGQ = quadrature, control = glmerControl(optimizer = optimizer))
  }
  # The start that the link's own gives fails where a whole level is at one half.
  fit_fixed <- function() {
    glm(as.formula(fixed), data = rows, family = link, control = glm.control(maxit = 200),
        mustart = ifelse(rows$correct == 1, 0.9, 0.6))
  }
  list("mixed model, Laplace, bobyqa" = fit_mixed("bobyqa", 1),
       "mixed model, Laplace, Nelder-Mead" = fit_mixed("Nelder_Mead", 1),
       "mixed model, FALLBACK nAGQ = 0 (no maximum likelihood), bobyqa" = fit_mixed("bobyqa", 0),
       "mixed model, FALLBACK nAGQ = 0 (no maximum likelihood), Nelder-Mead" = fit_mixed("Nelder_Mead", 0),
       "FIXED EFFECTS ALONE, no term for subjects" = fit_fixed)
}

# A fit, or the words of its error; with the warnings that it gave.
try_fit <- function(attempt) {
  warnings <- character()
  fit <- tryCatch(
    withCallingHandlers(attempt(), warning = function(w) {
      warnings <<- c(warnings, conditionMessage(w))
      invokeRestart("muffleWarning")
    }),
    error = function(e) conditionMessage(e))
  if (!is.character(fit) && any(!is.finite(fitted(fit)))) fit <- "fitted proportions are not finite"
  list(fit = fit, warnings = unique(warnings))
}

# On the scale of the link, where the coefficients are: what one subject differs from another by.
print_subjects <- function(fit, label) {
  if (!inherits(fit, "merMod")) return(invisible(NULL))
  cat(sprintf("standard deviation of subjects, %s: %.4f on the scale of the link\n", label,
              attr(VarCorr(fit)$participant, "stddev")))
}

# Probabilities of 0, 1, ... right among independent answers of these probabilities.
distribute_right <- function(probabilities) {
  density <- 1
  for (p in probabilities) density <- c(density * (1 - p), 0) + c(0, density * p)
  density
}

# Twice the smaller tail of the number of right answers, exact.
eval_tail <- function(right, probabilities) {
  density <- distribute_right(probabilities)
  counts <- seq_along(density) - 1
  min(1, 2 * min(sum(density[counts <= right]), sum(density[counts >= right])))
}

# Levels whose number of right answers lies farther from the fitted probabilities than chance takes it: two-sided exact p, after Holm over
# the levels, of 0.05 or less.
compare_levels <- function(rows, probabilities, label) {
  right <- tapply(rows$correct, rows$clamp_level, sum)
  expected <- tapply(probabilities, rows$clamp_level, sum)
  spread <- sqrt(tapply(probabilities * (1 - probabilities), rows$clamp_level, sum))
  z <- ifelse(abs(right - expected) < 1e-6, 0, (right - expected) / spread)
  by_level <- split(probabilities, rows$clamp_level)
  p <- p.adjust(mapply(eval_tail, right[names(by_level)], by_level), "holm")
  cat("proportion correct by clamp level, observed and fitted, and their difference in standard errors:\n")
  n <- tapply(rows$correct, rows$clamp_level, length)
  print(round(rbind(observed = right / n, fitted = expected / n, z = z), 3))
  differ <- p <= 0.05
  if (!any(differ)) cat(sprintf("levels, %s: at none do observed and fitted differ by more than chance\n", label))
  for (level in names(p)[differ]) {
    cat(sprintf("levels, %s: at C%s observed %.3f and fitted %.3f DIFFER by more than chance (p by Holm %.2g)\n", label, level,
                right[level] / n[level], expected[level] / n[level], p[level]))
  }
}

# Proportion correct falls with clamp for artifacts and rises for material, from one half up to one; subjects differ in
# where they stand. `distance` is the clamp level. Says which of the attempts was fitted and why those before it were not.
fit_experiment <- function(answers, label) {
  if (length(unique(answers$correct)) < 2 || length(unique(answers$participant)) < 3) {
    cat(sprintf("\n%s: not fitted, all answers are alike or there are fewer than three subjects\n", label))
    return(invisible(NULL))
  }
  rows <- transform(answers, distance = standardise(clamp_level), counts = standardise(log10(vpls)))
  varies <- function(name) if (length(unique(rows[[name]])) > 1) name
  terms <- unlist(lapply(c("distance", "counts", "material", "geometry", "illumination"), varies))
  if (is.null(terms)) terms <- "1"
  attempts <- make_attempts(terms, rows)
  for (name in names(attempts)) {
    result <- try_fit(attempts[[name]])
    if (!is.character(result$fit)) break
    cat(sprintf("\n%s: no %s: %s\n", label, name, result$fit))
  }
  fit <- result$fit
  if (is.character(fit)) return(invisible(NULL))
  cat(sprintf("\n%s: %d answers, %d subjects%s\n", label, nrow(rows), length(unique(rows$participant)),
              if (inherits(fit, "merMod") && isSingular(fit)) "; subjects do not differ (singular)" else ""))
  cat(sprintf("fitted %s: %s\n", label, name))
  print(round(coef(summary(fit)), 4))
  if (any(coef(summary(fit))[, "Std. Error"] > 100)) {
    cat("warning: answers are parted by a step (separation): coefficients have no finite estimate, fitted proportions do\n")
  }
  for (text in result$warnings) cat("warning:", text, "\n")
  print_subjects(fit, label)
  compare_levels(rows, fitted(fit), label)
  cat(sprintf("overall %s: observed %.4f, fitted %.4f\n", label, mean(rows$correct), mean(fitted(fit))))
}

compare_cells(answers, cells)
for (study in unique(answers$study)) {
  for (experiment in unique(answers$experiment[answers$study == study])) {
    fit_experiment(answers[answers$study == study & answers$experiment == experiment, ], paste(study, experiment))
  }
}
