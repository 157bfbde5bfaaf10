// Contrast of all visible text with what is behind it, as WCAG 2 defines it.

export const contrasts = (page) =>
  page.evaluate(() => {
    const numbers = (color) => {
      const [r, g, b, a = 1] = color.match(/[\d.]+/g).map(Number);
      return [r, g, b, a];
    };
    const luminance = ([r, g, b]) => {
      const linear = [r, g, b].map((x) => (x / 255 <= 0.04045 ? x / 255 / 12.92 : ((x / 255 + 0.055) / 1.055) ** 2.4));
      return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
    };
    const behind = (node) => {
      for (let at = node; at; at = at.parentElement) {
        const color = numbers(getComputedStyle(at).backgroundColor);
        if (color[3] > 0) return color;
      }
      return [255, 255, 255, 1];
    };
    const texts = [];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const node = walker.currentNode.parentElement, text = walker.currentNode.textContent.trim();
      if (!text || ["SCRIPT", "STYLE"].includes(node.tagName) || !node.checkVisibility()) continue;
      const style = getComputedStyle(node), lights = [luminance(numbers(style.color)), luminance(behind(node))];
      const contrast = (Math.max(...lights) + 0.05) / (Math.min(...lights) + 0.05);
      texts.push({ text: text.slice(0, 40), contrast, pixels: parseFloat(style.fontSize) });
    }
    return texts;
  });
