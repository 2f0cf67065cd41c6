# Mixed-effects models of the answers, and the same proportions and tails from R: equilux-analyze export and report made the files.
# Usage: Rscript analysis/r/mixed_models.R answers.csv cells.csv
# Debian packages: r-base-core r-cran-lme4 r-cran-psyphy. source: Knoblauch and Maloney 2012, chapters 4 and 9.
suppressPackageStartupMessages({
  library(lme4)
  library(psyphy)
})

arguments <- commandArgs(trailingOnly = TRUE)
if (length(arguments) != 2) stop("usage: mixed_models.R answers.csv cells.csv")
answers <- read.csv(arguments[1], stringsAsFactors = FALSE)
cells <- read.csv(arguments[2], stringsAsFactors = FALSE)

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

# Proportion correct falls with clamp for artifacts and rises for material, from one half up to one; subjects differ in
# where they stand. `distance` is the clamp level. A fit that did not converge is reported as such, and no number of it.
fit_experiment <- function(answers, label) {
  rows <- transform(answers, distance = clamp_level, counts = log10(vpls))
  terms <- c("distance", if (length(unique(rows$counts)) > 1) "counts",
             if (length(unique(rows$material)) > 1) "material", if (length(unique(rows$geometry)) > 1) "geometry",
             if (length(unique(rows$illumination)) > 1) "illumination")
  formula <- as.formula(paste("correct ~", paste(terms, collapse = " + "), "+ (1 | participant)"))
  if (length(unique(rows$correct)) < 2 || length(unique(rows$participant)) < 3) {
    cat(sprintf("\n%s: not fitted, all answers are alike or there are fewer than three subjects\n", label))
    return(invisible(NULL))
  }
  warnings <- character()
  fit <- tryCatch(
    withCallingHandlers(
      glmer(formula, data = rows, family = binomial(mafc.logit(.m = 2)), nAGQ = 0,
            control = glmerControl(optimizer = "bobyqa")),
      warning = function(w) {
        warnings <<- c(warnings, conditionMessage(w))
        invokeRestart("muffleWarning")
      }),
    error = function(e) conditionMessage(e))
  if (is.character(fit)) {
    cat(sprintf("\n%s: no fit: %s\n", label, fit))
    return(invisible(NULL))
  }
  cat(sprintf("\n%s: %d answers, %d subjects%s\n", label, nrow(rows), length(unique(rows$participant)),
              if (isSingular(fit)) "; subjects do not differ (singular)" else ""))
  print(round(coef(summary(fit)), 4))
  for (text in unique(warnings)) cat("warning:", text, "\n")
  fitted_by_level <- tapply(fitted(fit), rows$clamp_level, mean)
  observed <- tapply(rows$correct, rows$clamp_level, mean)
  cat("proportion correct by clamp level, observed and fitted:\n")
  print(round(rbind(observed, fitted = fitted_by_level), 3))
  cat(sprintf("overall %s: observed %.4f, fitted %.4f\n", label, mean(rows$correct), mean(fitted(fit))))
}

compare_cells(answers, cells)
for (study in unique(answers$study)) {
  for (experiment in unique(answers$experiment[answers$study == study])) {
    fit_experiment(answers[answers$study == study & answers$experiment == experiment, ], paste(study, experiment))
  }
}
